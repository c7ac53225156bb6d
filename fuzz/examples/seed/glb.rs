//! A hand of one vertex a joint, as a binary glTF file.

/// Its bytes.
pub(crate) fn hand() -> Vec<u8> {
    let names: Vec<String> = std::iter::once("wrist".to_owned())
        .chain(
            ["metacarpal", "phalanx-proximal", "phalanx-distal", "tip"]
                .map(|p| format!("thumb-{p}")),
        )
        .chain(["index", "middle", "ring", "pinky"].iter().flat_map(|finger| {
            ["metacarpal", "phalanx-proximal", "phalanx-intermediate", "phalanx-distal", "tip"]
                .map(|phalanx| format!("{finger}-finger-{phalanx}"))
        }))
        .collect();
    let n = names.len();
    let place = |k: usize| match k {
        0 => [0.0; 3],
        1..=4 => [-0.04, -0.01, -0.02 * k as f32],
        _ => [0.02 * ((k - 5) / 5) as f32 - 0.03, 0.0, -0.03 - 0.03 * ((k - 5) % 5) as f32],
    };
    let mut blob = Vec::new();
    let mut floats = |values: &[f32]| values.iter().for_each(|v| blob.extend(v.to_le_bytes()));
    for k in 0..n {
        let [x, y, z] = place(k).map(|value| -value);
        floats(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0]);
    }
    (0..n).for_each(|k| floats(&place(k)));
    (0..n).for_each(|_| floats(&[1.0, 0.0, 0.0, 0.0]));
    (0..n).for_each(|k| blob.extend([k as u8, 0, 0, 0]));
    blob.extend([0, 1, 2, 3, 4, 5, 0, 0]);
    let mut at = 0;
    let views = [64 * n, 12 * n, 16 * n, 4 * n, 6].map(|length| {
        at += length;
        format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{length}}}"#, at - length)
    });
    let nodes: Vec<String> = names.iter().map(|name| format!(r#"{{"name":"{name}"}}"#)).collect();
    let joints: Vec<String> = (0..n).map(|k| k.to_string()).collect();
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}}}],"bufferViews":[{}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{n},"type":"MAT4"}},
{{"bufferView":1,"componentType":5126,"count":{n},"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]}},
{{"bufferView":2,"componentType":5126,"count":{n},"type":"VEC4"}},
{{"bufferView":3,"componentType":5121,"count":{n},"type":"VEC4"}},
{{"bufferView":4,"componentType":5121,"count":6,"type":"SCALAR"}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":1,"WEIGHTS_0":2,"JOINTS_0":3}},"indices":4}}]}}],
"skins":[{{"inverseBindMatrices":0,"joints":[{}]}}],
"nodes":[{},{{"mesh":0,"skin":0}}]}}"#,
        blob.len(),
        views.join(","),
        joints.join(","),
        nodes.join(",")
    );
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let part = |kind: &[u8; 4], bytes: &[u8]| {
        [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat()
    };
    let parts = [part(b"JSON", json.as_bytes()), part(b"BIN\0", &blob)].concat();
    let length = (12 + parts.len() as u32).to_le_bytes();
    [&b"glTF\x02\0\0\0"[..], &length, &parts].concat()
}
