//! A job as an Open Job Description bundle (Open Job Description, Template Schemas 2023-09), which
//! render farms accept unchanged.

use serde_json::{Value as Json, json};

use super::job::Job;

/// Template of the job in JSON. The specification allows JSON and YAML.
pub fn files(job: &Job) -> Vec<(String, String)> {
    let mut steps = Vec::new();
    if let Some(lights) = &job.lights {
        steps.push(json!({ "name": "Lights", "script": script(lights) }));
    }
    let mut render = json!({
        "name": "Render",
        "parameterSpace": {
            "taskParameterDefinitions": [{ "name": "Share", "type": "INT", "range": format!("1-{}", job.shares) }],
        },
        "script": script(&job.share("{{Task.Param.Share}}")),
    });
    if job.lights.is_some() {
        render["dependencies"] = json!([{ "dependsOn": "Lights" }]);
    }
    steps.push(render);
    steps.push(json!({ "name": "Merge", "dependencies": [{ "dependsOn": "Render" }], "script": script(job.merge()) }));
    let template = json!({ "specificationVersion": "jobtemplate-2023-09", "name": job.name, "steps": steps });
    let text = serde_json::to_string_pretty(&template).expect("words and lists of words");
    vec![("template.json".to_owned(), format!("{text}\n"))]
}

fn script(line: &[String]) -> Json {
    json!({ "actions": { "onRun": { "command": line[0], "args": line[1..] } } })
}
