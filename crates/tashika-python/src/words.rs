//! Arguments that are words; each error lists the accepted words.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use tashika::film::Matte;
use tashika::gather::Filter;
use tashika::integrator::SumMethod;
use tashika::render::TileShare;
use tashika::request::{ClaimName, MethodName, Quality};
use tashika::scene::LightGrouping;
use tashika::vpl::Clamp;

use crate::errors::{option, raised};

/// Finds one of `all` by its displayed name.
pub fn named<T: Copy + ToString>(argument: &str, name: &str, all: &[T]) -> PyResult<T> {
    all.iter().copied().find(|one| one.to_string() == name).ok_or_else(|| {
        let names: Vec<String> = all.iter().map(T::to_string).collect();
        option(argument, name, names.join(" or "))
    })
}

/// Parses the name of a method that makes images.
pub fn method(name: &str) -> PyResult<MethodName> {
    name.parse().map_err(raised)
}

/// Parses the name of a measured method: any but the exact one, by which the others are judged.
pub fn measured(name: &str) -> PyResult<SumMethod> {
    let all = all_measured();
    all.iter()
        .copied()
        .find(|method| method.name() == name)
        .ok_or_else(|| option("methods", name, all.iter().map(|m| m.name()).collect::<Vec<_>>().join(", ")))
}

/// All methods that can be measured.
pub fn all_measured() -> Vec<SumMethod> {
    SumMethod::ALL.into_iter().filter(|method| *method != SumMethod::Exact).collect()
}

/// Parses the kind of claim of an interval.
pub fn claim(name: &str) -> PyResult<ClaimName> {
    name.parse().map_err(raised)
}

/// Parses the name of a quality preset.
pub fn quality(name: &str) -> PyResult<Quality> {
    name.parse().map_err(raised)
}

/// Parses the name of a pixel filter.
pub fn filter(name: &str) -> PyResult<Filter> {
    name.parse().map_err(raised)
}

/// Parses a clamp: `"auto"`, `"off"` or metres.
pub fn clamp(value: &Bound<'_, PyAny>) -> PyResult<Clamp> {
    match (value.extract::<String>().as_deref(), value.extract::<f32>()) {
        (Ok("auto"), _) => Ok(Clamp::Auto),
        (Ok("off"), _) => Ok(Clamp::Off),
        (_, Ok(metres)) => Ok(Clamp::Distance(metres)),
        _ => Err(option("clamp", value.str()?, "auto, off, or a distance in metres, such as 0.1")),
    }
}

/// Ranks of mattes from a number, or from true or false.
pub fn ranks(value: &Bound<'_, PyAny>) -> PyResult<Option<u32>> {
    if let Ok(wanted) = value.extract::<bool>() {
        return Ok(wanted.then_some(Matte::RANKS));
    }
    match value.extract::<u64>() {
        Ok(asked) => Matte::ranks(asked).map(Some).map_err(raised),
        Err(_) => Err(option("cryptomatte", value.str()?, "True, False, or a number of ranks")),
    }
}

/// Light groups from `"each"`, or from names of groups with lists of the names of their lights.
pub fn groups(value: &Bound<'_, PyAny>) -> PyResult<LightGrouping> {
    if let Ok(word) = value.extract::<String>() {
        return LightGrouping::parse([&*word]).map_err(raised);
    }
    let Ok(groups) = value.cast::<PyDict>() else {
        return Err(option("groups", value.str()?, "\"each\", or a dict of groups with names of lights"));
    };
    let named = groups.iter().map(|(group, lights)| Ok((group.extract()?, lights.extract()?)));
    Ok(LightGrouping::Named(named.collect::<PyResult<_>>()?))
}

/// Share of tiles from `"K/N"`, a list such as `"1,3/4"`, or `(K, N)`.
pub fn tiles(value: &Bound<'_, PyAny>) -> PyResult<TileShare> {
    let share = match value.extract::<(u32, u32)>() {
        Ok((number, of)) => TileShare::new(number, of),
        Err(_) => value.str()?.to_cow()?.parse(),
    };
    share.map_err(raised)
}
