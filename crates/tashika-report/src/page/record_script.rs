//! What the scripts of a page know of films: the tables of `film::record`, as an object `Record`.
//!
//! | field | what it has |
//! |---|---|
//! | `plane` | names of the planes, by the names of their rows in lower case: `Record.plane.half_width` |
//! | `planes` | what each plane is called and how it is shown; codes with words and colours |
//! | `key` | names in the metadata: `Record.key.confidence` |
//! | `control` | names of what may be controlled: `Record.control.channels` |
//! | `tones` | matrices and curves of tone mappings that are made of such, by name: `Record.tones.agx.inset` |
//! | `claim`, `stop` | codes by name: `Record.claim.none`, `Record.stop.not_rendered` |
//!
//! # Held to this by
//! `report::page::tests`: the scripts use no other names.

use serde_json::{Map, Value as Json, json};

use crate::color::Controlled;
use crate::film::{Claim, Code, SCHEMA, Stop, Tone, keys};

/// The object, as a script.
pub(super) fn text() -> String {
    // Inside a script element only `<` could end it or begin a comment.
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
