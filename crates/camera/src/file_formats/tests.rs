use glam::DVec2;

use super::*;

const OPENCV_YAML: &str = "%YAML:1.0\n---\ncalibration_time: \"Mon\"\nimage_width: 346\n\
    image_height: 260\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: \
    [ 3.1e+02, 0., 1.72e+02, 0., 3.11e+02,\n       1.29e+02, 0., 0., 1. ]\n\
    distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ -0.3, \
    0.1, 0., 0.,\n       0. ]\n";
const ROS_YAML: &str = "image_width: 346\nimage_height: 260\ncamera_name: davis\ncamera_matrix:\n  \
    rows: 3\n  cols: 3\n  data: [310, 0, 172, 0, 311, 129, 0, 0, 1]\ndistortion_model: plumb_bob\n\
    distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.3, 0.1, 0, 0, 0]\n";
const OPENCV_XML: &str = "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_width>346</image_width>\n\
    <image_height>260</image_height>\n<camera_matrix type_id=\"opencv-matrix\">\n<rows>3</rows>\n\
    <cols>3</cols>\n<dt>d</dt>\n<data>\n310. 0. 172. 0. 311. 129. 0. 0. 1.</data></camera_matrix>\n\
    <distortion_coefficients type_id=\"opencv-matrix\"><rows>5</rows><cols>1</cols><dt>d</dt><data>\n\
    -0.3 0.1 0. 0. 0.</data></distortion_coefficients>\n</opencv_storage>";
const DV_JSON: &str = "{\"cameras\": [{\"name\": \"DAVIS346_00000499\", \"position\": \"center\", \
    \"resolution\": [346, 260], \"distortion\": [-0.3, 0.1, 0, 0, 0], \"distortionModel\": \
    \"radialTangential\", \"focalLength\": [310, 311], \"principalPoint\": [172, 129]}]}";
const OWN_TOML: &str = "sensor = { width = 346, height = 260 }\nfocal_px = [310.0, 311.0]\n\
    principal_px = [172.5, 129.5]\ndistortion = [-0.3, 0.1, 0.0, 0.0, 0.0]\n";
fn read(text: &str) -> Result<CameraOfFile, CalibrationError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("calibration");
    std::fs::write(&path, text).unwrap();
    read_file(&path)
}

#[test]
fn the_same_camera_is_read_from_every_format() {
    let want = read(OWN_TOML).unwrap();
    assert_eq!(want.sensor, Some(SensorSize { width: 346, height: 260 }));
    assert_eq!(want.camera.focal_px, DVec2::new(310.0, 311.0));
    assert_eq!(want.camera.principal_px, DVec2::new(172.5, 129.5));
    for text in [OPENCV_YAML, ROS_YAML, OPENCV_XML, DV_JSON, OWN_TOML] {
        assert_eq!(read(text).unwrap(), want, "{text}");
        // A mark of the byte order is no part of any format.
        assert_eq!(read(&format!("\u{feff}{text}")).unwrap(), want, "{text}");
    }
    let values = "310 311 172 129";
    assert_eq!(read(&format!("\u{feff}{values}")).unwrap(), read(values).unwrap());
}

/// Each format, with its fields for the size, the focal lengths and the distortion.
const FORMATS: [(&str, [&str; 3]); 5] = [
    (OPENCV_YAML, ["image_width", "camera_matrix", "distortion_coefficients"]),
    (ROS_YAML, ["image_width", "camera_matrix", "distortion_coefficients"]),
    (OPENCV_XML, ["image_width", "camera_matrix", "distortion_coefficients"]),
    (DV_JSON, ["cameras[0].resolution", "cameras[0].focalLength", "cameras[0].distortion"]),
    (OWN_TOML, ["sensor", "focal_px", "distortion"]),
];

#[test]
fn no_format_takes_a_camera_that_cannot_be() {
    for (text, [size, focal, distortion]) in FORMATS {
        // Exponents would hide the values that are replaced below.
        let text = text.replace("3.1e+02", "310").replace("3.11e+02", "311");
        let longer = if text.starts_with("<?xml") { "-0.3 0.0" } else { "-0.3, 0.0" };
        for (value, spoilt, field) in [
            ("346", "0", size),
            ("260", "0", size),
            ("310", "0", focal),
            ("311", "0", focal),
            ("311", "-311", focal),
            ("-0.3", longer, distortion),
        ] {
            assert!(text.contains(value), "{value} in {text}");
            let message = read(&text.replace(value, spoilt)).unwrap_err().to_string();
            assert!(message.contains(&format!("{field}: ")), "{value}, {spoilt}: {message}");
        }
    }
}

#[test]
fn faults_name_the_field() {
    for (text, field) in [
        (OPENCV_YAML.replace("3.1e+02, 0.,", ""), "camera_matrix"),
        (ROS_YAML.replace("data: [310", "data: [-310"), "camera_matrix: focal"),
        (ROS_YAML.replace("172,", "nan,"), "camera_matrix: a principal point"),
        (ROS_YAML.replace("width: 346", "width: 346.5"), "image_width"),
        (ROS_YAML.replace("width: 346", "width: 65536"), "image_width"),
        (ROS_YAML.replace("data: [-0.3, 0.1, 0, 0, 0]", "data: [-0.3, 0.1, 0]"), "distortion"),
        (DV_JSON.replace("\"resolution\": [346, 260],", ""), "resolution"),
        (DV_JSON.replace("radialTangential", "omni"), "`omni` is not supported"),
        ("focal_px = 3".to_owned(), "calibration"),
    ] {
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains(field), "{error}");
    }
}

const ROS_MESSAGE: &str = "header:\n  seq: 1\nroi:\n  height: 0\n  width: 0\nheight: 260\nwidth: 346\n\
    distortion_model: \"plumb_bob\"\nD: [-0.3, 0.1, 0.0, 0.0, 0.0]\n\
    K: [310.0, 0.0, 172.0, 0.0, 311.0, 129.0, 0.0, 0.0, 1.0]\n";
const KALIBR: &str = "cam0:\n  cam_overlaps: [1]\n  camera_model: pinhole\n  distortion_coeffs: [-0.3, \
    0.1, 0.0, 0.0]\n  distortion_model: radtan\n  intrinsics: [310.0, 311.0, 172.0, 129.0]\n  \
    resolution: [346, 260]\ncam1:\n  intrinsics: [1.0, 1.0, 1.0, 1.0]\n";
/// As DV's module for calibration writes it, with an element for the camera.
const DV_XML: &str = "<?xml version=\"1.0\"?>\n<opencv_storage>\n<DAVIS346_00000499>\n\
    <camera_matrix type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt><data>\n\
    310. 0. 172. 0. 311. 129. 0. 0. 1.</data></camera_matrix>\n<distortion_coefficients \
    type_id=\"opencv-matrix\"><data>-0.3 0.1 0. 0. 0.</data></distortion_coefficients>\n\
    <image_width>346</image_width><image_height>260</image_height>\n</DAVIS346_00000499>\n\
    <use_fisheye_model>0</use_fisheye_model>\n<type>camera</type>\n</opencv_storage>";

#[test]
fn keys_are_read_where_they_stand() {
    let want = read(OWN_TOML).unwrap();
    let block: String = ["310", "0", "172", "0", "311", "129", "0", "0", "1"]
        .map(|value| format!("  - {value}.0 # no `data: [1]`\n"))
        .concat();
    let (before, behind) = ROS_YAML.split_once("camera_matrix:\n").unwrap();
    let behind = behind.split_once("]\n").unwrap().1;
    for text in [
        ROS_MESSAGE,
        KALIBR,
        DV_XML,
        &format!("{before}camera_matrix:\n{block}{behind}"),
        &format!("{before}camera_matrix:\n  data:\n{block}{behind}"),
        &format!("{before}K: [[310, 0, 172],\n    [0, 311, 129],\n    [0, 0, 1]]\n{behind}"),
        &format!("%YAML:1.0\n# camera_matrix: [1]\nold:\n  image_width: 640\n{ROS_YAML}"),
        &ROS_YAML.replace("matrix:\n", "matrix: # data: [1, 2]\n"),
        &ROS_YAML
            .replace("width: 346", "width: !!int 346")
            .replace("image_height:", "\"image_height\" : #\n "),
        &OPENCV_XML
            .replace("<camera_matrix", "<!-- <camera_matrix>1</camera_matrix> --><camera_matrix"),
        &OPENCV_XML.replace("310. 0.", "310. <!-- 305. --> 0."),
    ] {
        assert_eq!(read(text).map_err(|error| error.to_string()).as_ref(), Ok(&want), "{text}");
    }
}

#[test]
fn faults_of_yaml_and_xml_name_the_line() {
    for (text, fault) in [
        (ROS_YAML.replace("172,", "x,"), "line 7: camera_matrix: `x` where a number is expected"),
        (ROS_YAML.replace(" 0, 0, 1]", "]"), "line 7: camera_matrix: 6 values instead of 9"),
        (
            OPENCV_YAML.replace("260", "[260, 1]"),
            "line 4: image_width: 3 values for width and height",
        ),
        (OPENCV_XML.replace("0. 1.<", "<"), "line 9: camera_matrix: 7 values instead of 9"),
        (KALIBR.replace("310.0", "-1.0"), "line 6: cam0.intrinsics: focal lengths"),
        (KALIBR.replace("radtan", "fov"), "line 5: cam0.distortion_model: `fov` is not"),
        (KALIBR.replace("pinhole", "omni"), "line 3: cam0.camera_model: `omni` is not supported"),
        (DV_XML.replace(">0<", ">1<"), "5 coefficients of a fisheye lens; there are 4"),
        (ROS_YAML.replace("camera_matrix", "matrix"), "no `camera_matrix`, `K` or `intrinsics`"),
        (ROS_YAML.replace("[310", "{310"), "line 7"),
        (OPENCV_XML.replace("</image_width>", "</width>"), "at 3:"),
        (format!("K: {}", "[".repeat(100_000)), "recursion limit"),
        ("- ".repeat(100_000), "more than 255 levels"),
        ("<?xml version=\"1.0\"?>".to_owned() + &"<a>".repeat(100_000), "never closed"),
    ] {
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains(fault), "{error} instead of {fault}");
    }
}

/// A camera of DSEC's `cam_to_cam.yaml`, whose first is the left event camera.
const DSEC: &str = "extrinsics:\n  T_10:\n  - [1.0, 0.0, 0.0, 0.0]\n  - [0.0, 1.0, 0.0, 0.0]\n\
    intrinsics:\n  cam0:\n    camera_matrix: [310.0, 311.0, 172.0, 129.0]\n    camera_model: pinhole\n    \
    distortion_coeffs: [-0.3, 0.1, 0.0, 0.0]\n    distortion_model: radtan\n    resolution: [346, \
    260]\n  cam1:\n    camera_matrix: [1.0, 1.0, 1.0, 1.0]\n    camera_model: omni\n  camRect0:\n    \
    camera_matrix: [2.0, 2.0, 2.0, 2.0]\n";
/// As rpg's programs write a rig.
const RPG_YAML: &str = "label: davis\nid: 1\ncameras:\n- camera:\n    label: cam0\n    image_height: 260\n    \
    image_width: 346\n    type: pinhole\n    intrinsics:\n      cols: 1\n      rows: 4\n      data: [310, 311, \
    172, 129]\n    distortion:\n      type: radial-tangential\n      parameters:\n        cols: 1\n        \
    rows: 4\n        data: [-0.3, 0.1, 0.0, 0.0]\n  T_B_C:\n    cols: 4\n    rows: 4\n    data: [1, 0, 0, 0, 0, \
    1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";

#[test]
fn rigs_of_dsec_and_rpg_and_lines_of_values_are_read() {
    let want = read(OWN_TOML).unwrap();
    for text in [DSEC, RPG_YAML] {
        assert_eq!(read(text).map_err(|error| error.to_string()).as_ref(), Ok(&want), "{text}");
    }
    let line = read("310.0 311.0 172.0 129.0 -0.3 0.1 0.0 0.0 0.0\n").unwrap();
    assert_eq!((line.camera, line.sensor), (want.camera, None));
    let error = read("310 311 172 129 -0.3 0.1 0 0").unwrap_err().to_string();
    assert!(error.contains("8 values"), "{error}");
    let error = read("0 311 172 129").unwrap_err().to_string();
    assert!(error.contains("focal lengths of [0.0, 311.0]"), "{error}");
    let error = read(&RPG_YAML.replace("radial-tangential", "fov")).unwrap_err().to_string();
    assert!(error.contains("cameras[0].camera.distortion.type: `fov` is not supported"), "{error}");
}

/// A second camera of another lens, in a list of each format and before the first one's model.
#[test]
fn each_camera_of_a_list_has_its_own_lens() {
    let want = read(OWN_TOML).unwrap();
    let (head, camera) = RPG_YAML.split_once("- camera:").unwrap();
    let other = camera.replace("radial-tangential", "equidistant").replace("310, 311", "9, 9");
    let item = |yaml: &str| format!("- {}\n", yaml.trim_end().replace('\n', "\n  "));
    let fisheye = ROS_MESSAGE.replace("plumb_bob", "equidistant").replace("310.0", "9.0");
    let camera_of = |xml: &str| {
        let begin = xml.find("<camera_matrix").unwrap();
        let end = xml.find("</opencv_storage>").unwrap();
        let size = "<image_width>346</image_width><image_height>260</image_height>";
        format!("<_>{size}{}</_>", &xml[begin..end])
    };
    let model = |word: &str| {
        format!("</distortion_coefficients><distortion_model>{word}</distortion_model>")
    };
    let [usual, equidistant] = ["plumb_bob", "equidistant"]
        .map(|word| camera_of(&OPENCV_XML.replace("</distortion_coefficients>", &model(word))));
    for text in [
        format!("{head}- camera:{camera}- camera:{other}"),
        format!("{}{}", item(ROS_MESSAGE), item(&fisheye)),
        format!(
            "<?xml version=\"1.0\"?><opencv_storage><cameras>{usual}{equidistant}</cameras></opencv_storage>"
        ),
        // The model of a rig is that of the cameras that do not state one.
        KALIBR.replace("cam0:", "distortion_model: equidistant\ncam0:"),
    ] {
        assert_eq!(read(&text).map_err(|error| error.to_string()).as_ref(), Ok(&want), "{text}");
    }
}

#[test]
fn fisheye_lenses_are_read_from_every_format_and_are_no_plumb_bob() {
    let toml = OWN_TOML.replace(", 0.0]", "]") + "fisheye = true\n";
    let want = read(&toml).unwrap();
    assert_eq!(want.camera.distortion.fisheye, Some([-0.3, 0.1, 0.0, 0.0]));
    let four = |text: &str| text.replace("0.1, 0, 0, 0]", "0.1, 0, 0]");
    for text in [
        four(ROS_YAML).replace("plumb_bob", "equidistant"),
        four(DV_JSON).replace("radialTangential", "equidistant"),
        KALIBR.replace("radtan", "equidistant"),
        DSEC.replace("radtan", "equidistant"),
        RPG_YAML.replace("radial-tangential", "equidistant"),
        DV_XML.replace(">0<", ">1<").replace("-0.3 0.1 0. 0. 0.", "-0.3 0.1 0. 0."),
    ] {
        assert_eq!(read(&text).map_err(|error| error.to_string()).as_ref(), Ok(&want), "{text}");
    }
}
