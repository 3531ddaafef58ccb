use proptest::prelude::*;

use super::*;

fn rows() -> Vec<MatchRow> {
    vec![
        MatchRow {
            id: 0,
            left: Vec2::new(548.5, 187.25),
            right: Vec2::new(219.0, 187.75),
            disparity: Some(329.5),
            position: Some(Vec3::new(-1.5, 2.25, 1300.125)),
            lattice: Some([-3, 17]),
            score: 0.5,
        },
        MatchRow {
            id: 4,
            left: Vec2::new(1.0, 2.0),
            right: Vec2::new(3.0, 4.0),
            disparity: None,
            position: None,
            lattice: None,
            score: 1.0,
        },
    ]
}

#[test]
fn matches_have_exactly_the_documented_columns() {
    let text = matches_csv(&rows());
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "id,xl,yl,xr,yr,disparity,x_mm,y_mm,z_mm,column,row,score");
    assert_eq!(
        lines[1],
        "0,548.50000,187.25000,219.00000,187.75000,329.50000,-1.50000,2.25000,1300.12500,-3,17,0.5000"
    );
    assert_eq!(lines[2], "4,1.00000,2.00000,3.00000,4.00000,,,,,,,1.0000");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("matches.csv");
    write_matches(&path, &rows()).unwrap();
    assert_eq!(read_matches(&path).unwrap(), rows());
    assert_eq!(read_points(&path).unwrap().points, vec![Vec3::new(-1.5, 2.25, 1300.125)]);
}

#[test]
fn tables_of_other_programs_are_read() {
    let found = parse_matches(b"xr;yr;xl;yl;note\n3;4;1;2;a\n\n# end\n").unwrap();
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].left, found[0].score), (Vec2::new(1.0, 2.0), 1.0));
    for text in [
        "1 2 3\n4 5 6\n",
        "X,Y,Z\n1,2,3\n4,5,6\n",
        "z_mm\ty_mm\tx_mm\n3\t2\t1\n6\t5\t4",
        "1,2,3,9\r\n4,5,6,9",
    ] {
        let cloud = parse_points(text.as_bytes()).unwrap();
        assert_eq!(
            cloud.points,
            vec![Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 5.0, 6.0)],
            "{text}"
        );
    }
}

#[test]
fn faults_name_the_line_and_the_column() {
    let message = |bytes: &[u8]| parse_matches(bytes).unwrap_err().to_string();
    assert!(message(b"").contains("empty"));
    assert!(message(b"xl,yl,xr\n1,2,3").contains("no column yr"));
    assert!(message(b"xl,yl,xr,yr\n1,2,3,4\n1,2,x,4").contains("line 3: \"x\""));
    assert!(message(b"xl,yl,xr,yr\n1,2,,4").contains("line 2"));
    assert!(message(b"xl,yl,xr,yr\n1,2,nan,4").contains("not a possible value"));
    assert!(parse_points(b"a,b\n1,2").is_err());
    assert!(parse_points(b"1 2\n").unwrap_err().to_string().contains("line 1"));
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("empty.csv");
    std::fs::write(&path, "x,y,z\n").unwrap();
    assert!(read_points(&path).unwrap_err().to_string().contains("no points"));
}

proptest! {
    #[test]
    fn no_text_panics(text in "[a-z0-9,;. \n\t\"-]{0,200}") {
        let _ = parse_matches(text.as_bytes());
        let _ = parse_points(text.as_bytes());
        let _ = parse_matches(format!("xl,yl,xr,yr,column,row,id\n{text}").as_bytes());
    }
}
