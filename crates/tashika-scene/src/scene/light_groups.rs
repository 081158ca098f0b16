//! Groups of a scene's lights by name, for images that show the contribution of each group.
//!
//! An instance that emits is selected by the name of its object or of its material, an emitter
//! without surface by its own name, and the environment by the name `environment`.

use std::collections::BTreeMap;
use std::fmt;

use super::{Emission, InstanceId, Scene};
use crate::error::{Error, Result};

/// Name of the environment as a light.
const ENVIRONMENT: &str = "environment";
/// Name of the group of lights that no group lists.
const REST: &str = "rest";

/// A light of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightId {
    /// An instance whose material emits.
    Instance(InstanceId),
    /// An emitter without surface, by its index in [`Scene::emitters`].
    Emitter(u32),
    /// Light seen where a ray meets no surface.
    Environment,
}

/// Assignment of lights to groups.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LightGrouping {
    /// One group for each name of lights.
    Each,
    /// Names of groups, each with the names of its lights. All other lights form the group `rest`.
    Named(Vec<(String, Vec<String>)>),
}

impl fmt::Display for LightGrouping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Each => f.write_str("each"),
            Self::Named(groups) => {
                let said = groups.iter().map(|(group, lights)| format!("{group}={}", lights.join(",")));
                f.write_str(&said.collect::<Vec<_>>().join(" "))
            }
        }
    }
}

impl LightGrouping {
    /// Parses words: either `each`, or groups with their lights, `GROUP=NAME,NAME`. A group may be
    /// repeated.
    ///
    /// # Errors
    /// [`Error::Option`] naming `groups` for anything else.
    pub fn parse<'t>(words: impl IntoIterator<Item = &'t str>) -> Result<Self> {
        let expected = "each, alone, or GROUP=NAME,NAME with names of lights";
        let (mut groups, mut each) = (Vec::<(String, Vec<String>)>::new(), false);
        for word in words {
            let refused = || Error::option("groups", word, expected);
            if word == "each" {
                each = true;
            } else {
                let (group, names) = word.split_once('=').ok_or_else(refused)?;
                let names: Vec<String> = names.split(',').map(|name| name.trim().to_owned()).collect();
                if group.is_empty() || names.iter().any(String::is_empty) {
                    return Err(refused());
                }
                match groups.iter_mut().find(|(known, _)| known == group) {
                    Some((_, known)) => known.extend(names),
                    None => groups.push((group.to_owned(), names)),
                }
            }
            if each && !groups.is_empty() {
                return Err(refused());
            }
        }
        match (each, groups.is_empty()) {
            (true, _) => Ok(Self::Each),
            (false, false) => Ok(Self::Named(groups)),
            (false, true) => Err(Error::option("groups", "nothing", expected)),
        }
    }
}

/// Groups of the lights of one scene; every light is in exactly one.
#[derive(Clone, Debug, PartialEq)]
pub struct LightGroups {
    names: Vec<String>,
    instances: BTreeMap<InstanceId, usize>,
    emitters: Vec<usize>,
    environment: usize,
}

impl LightGroups {
    /// Largest number of groups.
    pub const MOST: usize = 32;

    /// Forms the groups of a scene's lights, in the order of `grouping`; with one group for each
    /// name, in the order of the lights.
    ///
    /// # Errors
    /// [`Error::Option`] naming `groups`: a name that no light has, a light that is in two groups,
    /// two groups with equal layer names, more groups than [`Self::MOST`].
    pub fn new(scene: &Scene, grouping: &LightGrouping) -> Result<Self> {
        let refused = |found: &str, expected: String| Error::option("groups", found, expected);
        let mut names: Vec<String> = match grouping {
            LightGrouping::Each => Vec::new(),
            LightGrouping::Named(groups) => groups.iter().map(|(name, _)| name.clone()).collect(),
        };
        let mut used = BTreeMap::new();
        let mut group_of = |aliases: &[&str]| -> Result<usize> {
            let mut found = None;
            if let LightGrouping::Named(groups) = grouping {
                for (g, (name, lights)) in groups.iter().enumerate() {
                    for light in lights.iter().filter(|light| aliases.contains(&light.as_str())) {
                        used.insert(light.clone(), ());
                        if found.is_some_and(|other| other != g) {
                            let expected =
                                format!("each light in one group, but {light} is in {name} and another");
                            return Err(refused(&grouping.to_string(), expected));
                        }
                        found = Some(g);
                    }
                }
            }
            let name = if grouping == &LightGrouping::Each { aliases[0] } else { REST };
            Ok(found.or_else(|| names.iter().position(|known| known == name)).unwrap_or_else(|| {
                names.push(name.to_owned());
                names.len() - 1
            }))
        };
        let mut instances = BTreeMap::new();
        let mut all = Vec::new();
        let shines = |emission: &Emission| !emission.radiance.factor.is_black();
        for (instance, _) in scene.area_emitters().filter(|(_, emission)| shines(emission)) {
            let aliases = [scene.object_name(instance), scene.material_of(instance).name.as_str()];
            instances.insert(instance, group_of(&aliases)?);
            all.extend(aliases.map(str::to_owned));
        }
        let mut emitters = Vec::new();
        for place in 0..scene.emitters().len() {
            let name = scene.light_name(place);
            emitters.push(group_of(&[&*name])?);
            all.push(name.into_owned());
        }
        let environment = match scene.environment() {
            Some(_) => {
                all.push(ENVIRONMENT.to_owned());
                group_of(&[ENVIRONMENT])?
            }
            None => 0,
        };
        if let LightGrouping::Named(groups) = grouping {
            let unknown =
                groups.iter().flat_map(|(_, lights)| lights).find(|light| !used.contains_key(*light));
            if let Some(unknown) = unknown {
                all.sort();
                all.dedup();
                let more = if all.len() > 20 { ", …" } else { "" };
                all.truncate(20);
                let expected = format!("names of lights of the scene: {}{more}", all.join(", "));
                return Err(refused(unknown, expected));
            }
        }
        if names.len() > Self::MOST {
            let expected = format!("at most {} groups: GROUP=NAME,NAME puts lights together", Self::MOST);
            return Err(refused(&format!("{} of them", names.len()), expected));
        }
        let groups = Self { names, instances, emitters, environment };
        let mut layers = groups.layers();
        layers.sort();
        match layers.windows(2).find(|two| two[0] == two[1]) {
            Some(two) => Err(refused(&two[0], "names that differ in letters and digits".to_owned())),
            None => Ok(groups),
        }
    }

    /// Number of groups; 0 for a scene without light.
    pub fn count(&self) -> usize {
        self.names.len()
    }

    /// Names of the groups, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Names of the groups as layer names: characters other than letters, digits, hyphens and
    /// underscores become underscores.
    pub fn layers(&self) -> Vec<String> {
        let plain = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' };
        self.names.iter().map(|name| name.chars().map(plain).collect()).collect()
    }

    /// Returns the index of the group of a light.
    ///
    /// # Panics
    /// If the scene has no such instance or emitter, or if the instance emits nothing.
    pub fn of(&self, light: LightId) -> usize {
        match light {
            LightId::Instance(instance) => self.instances[&instance],
            LightId::Emitter(place) => self.emitters[place as usize],
            LightId::Environment => self.environment,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn groups_are_said_as_they_are_typed() {
        let parse = |words: &[&str]| LightGrouping::parse(words.iter().copied());
        assert_eq!(parse(&["each"]).unwrap(), LightGrouping::Each);
        let named = parse(&["key=a, b", "fill=c", "key=d"]).unwrap();
        assert_eq!(named.to_string(), "key=a,b,d fill=c");
        for wrong in
            [&[][..], &["all"], &["=a"], &["key="], &["key=a,"], &["each", "key=a"], &["key=a", "each"]]
        {
            let said = parse(wrong).unwrap_err().to_string();
            assert!(said.starts_with("groups = ") && said.contains("GROUP=NAME"), "{said}");
        }
    }

    #[test]
    fn lights_are_in_the_group_that_names_them_or_in_the_rest() {
        let scene = builtin::room();
        let each = LightGroups::new(&scene, &LightGrouping::Each).unwrap();
        assert!(each.count() > 1, "{:?}", each.names());
        let first = &each.names()[0];
        let words = format!("key={first}");
        let two = LightGroups::new(&scene, &LightGrouping::parse([&*words]).unwrap()).unwrap();
        assert_eq!(two.names(), ["key", "rest"]);
        for (instance, _) in scene.area_emitters() {
            let light = LightId::Instance(instance);
            let is_first = &each.names()[each.of(light)] == first;
            assert_eq!(two.of(light), usize::from(!is_first));
        }
        let refusal = |words: &[&str]| {
            let grouping = LightGrouping::parse(words.iter().copied()).unwrap();
            LightGroups::new(&scene, &grouping).unwrap_err().to_string()
        };
        let said = refusal(&["key=no such lamp"]);
        assert!(said.contains("no such lamp") && said.contains(first), "{said}");
        let said = refusal(&[&words, &format!("other={first}")]);
        assert!(said.contains("each light in one group"), "{said}");
        let said = refusal(&[&format!("a.b={first}"), &format!("a:b={}", each.names()[1])]);
        assert!(said.contains("a_b"), "{said}");
    }
}
