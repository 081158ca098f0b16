//! Tables of `film::record` for the scripts of a page, as an object `Record`.
//!
//! | field | contents |
//! |---|---|
//! | `plane` | names of planes, by the lower-case names of their rows: `Record.plane.half_width` |
//! | `planes` | label and presentation of each plane; codes with words and colours |
//! | `key` | names in the metadata: `Record.key.confidence` |
//! | `control` | names of error metrics: `Record.control.channels` |
//! | `tones` | matrices and curves of published tone mappings: `Record.tones.agx.inset` |
//! | `claim`, `stop` | codes by name: `Record.claim.none`, `Record.stop.not_rendered` |
//!
//! # Held to this by
//! `report::page::tests`: the scripts use no names that are not in the tables.

use serde_json::{Map, Value as Json, json};

use crate::color::Controlled;
use crate::film::{Claim, Code, SCHEMA, Stop, Tone, keys};

/// Script that defines the object.
pub(super) fn text() -> String {
    // Inside a script element only `<` could end the element or begin a comment.
    let record = record().to_string().replace('<', "\\u003c");
    format!("\"use strict\";\n// The tables of film/record.\nconst Record = {record};\n")
}

pub(super) fn record() -> Json {
    let named = |names: &mut dyn Iterator<Item = (String, Json)>| Json::Object(names.collect::<Map<_, _>>());
    let codes = |codes: &[Code]| named(&mut codes.iter().map(|code| (code.name.to_owned(), code.id.into())));
    let planes =
        SCHEMA.iter().map(|row| json!({ "name": row.spec.name, "label": row.label, "shown": row.shown }));
    json!({
        "plane": named(&mut SCHEMA.iter().map(|row| (row.key.to_lowercase(), row.spec.name.into()))),
        "planes": planes.collect::<Vec<_>>(),
        "key": named(&mut keys::KEYS.iter().map(|key| (key.name.replace('.', "_"), key.name.into()))),
        "control": named(&mut Controlled::ALL.iter().map(|c| (c.to_string(), c.to_string().into()))),
        "tones": named(&mut Tone::ALL.iter().filter_map(|t| Some((t.to_string(), json!(t.published()?))))),
        "claim": codes(Claim::CODES),
        "stop": codes(Stop::CODES),
    })
}
