//! Every mistake that a VTK file can have gets a message that names the cell, the point, the array or the line.

use forms_fem::mesh::{Mesh, VtkReader};

const LEGACY: &str = "# vtk DataFile Version 3.0
a square and an edge
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 4 double
0 0 0
1 0 0
1 1 0
0 1 0
CELLS 3 11
3 0 1 2
3 0 2 3
2 0 1
CELL_TYPES 3
5
5
3
CELL_DATA 3
SCALARS region int 1
LOOKUP_TABLE default
1 2 7
";

const XML: &str = r#"<?xml version="1.0"?>
<!-- a square and an edge -->
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">
<UnstructuredGrid>
<FieldData><DataArray type="Float64" Name="time" NumberOfTuples="1" format="ascii">0</DataArray></FieldData>
<Piece NumberOfPoints="4" NumberOfCells="3">
<Points>
<DataArray type="Float64" Name="Points" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 1 1 0 0 1 0</DataArray>
</Points>
<Cells>
<DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 0 2 3 0 1</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">3 6 8</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">5 5 3</DataArray>
</Cells>
<CellData><DataArray type="Int32" Name="region" format="ascii">1 2 7</DataArray></CellData>
</Piece>
</UnstructuredGrid>
</VTKFile>
"#;

fn with<const D: usize>(reader: &VtkReader, text: &str) -> String {
    match reader.from_bytes::<D>("square", text.as_bytes()) {
        Ok(read) => {
            let mut regions: Vec<&str> = read.mesh.cell_region_names().skip(1).collect();
            regions.extend(read.mesh.facet_region_names().skip(1));
            format!("{} cells, {regions:?}, {:?}", read.mesh.cell_count(), read.notes)
        }
        Err(error) => error.to_string(),
    }
}

fn message(text: &str) -> String {
    with::<2>(&VtkReader::new(), text)
}

// The message for the file with one fragment replaced by another.
fn changed(file: &str, from: &str, to: &str) -> String {
    assert_eq!(file.matches(from).count(), 1, "{from:?} stands once");
    message(&file.replace(from, to))
}

#[test]
fn the_files_are_good() {
    for file in [LEGACY, XML] {
        let good = "2 cells, [\"region 1\", \"region 2\", \"facets 7\"], []";
        assert_eq!(message(file), good);
        assert_eq!(message(&file.replace('\n', "\r\n")), good);
    }
    // Other data and words of VTK's are in between.
    let more = LEGACY.replace("POINTS", "FIELD FieldData 1\ntime 1 1 double\n0.5\nPOINTS").replace(
        "CELL_DATA",
        "METADATA\nINFORMATION 0\n\nPOINT_DATA 4\nVECTORS u float\n0 0 0 1 1 1 2 2 2 3 3 3\nCELL_DATA",
    );
    let read = VtkReader::new().from_bytes::<2>("square", more.as_bytes()).unwrap();
    assert_eq!((read.point_data[0].name.as_str(), read.point_data[0].values[11]), ("u", 3.0));
}

#[test]
fn what_is_no_grid() {
    assert!(
        Mesh::<2>::read_vtk("no/such/file.vtu").unwrap_err().to_string().starts_with("no/such/file.vtu: ")
    );
    let no_file = "square: this is no VTK file: it begins with \"solid cube\", neither with <VTKFile nor with # vtk DataFile";
    assert_eq!(message("solid cube\n"), no_file);
    assert!(message("").starts_with("square: this is no VTK file"));
    assert!(
        message("<html></html>").starts_with("square: this is no VTK file: it begins with \"<html></html>\"")
    );
    assert_eq!(
        changed(LEGACY, "UNSTRUCTURED_GRID", "POLYDATA"),
        "square: the file holds POLYDATA; an unstructured grid of one piece is read"
    );
    assert_eq!(
        message("<VTKFile type=\"PolyData\"><PolyData></PolyData></VTKFile>"),
        "square: the file holds PolyData; an unstructured grid of one piece is read"
    );
    let twice = XML.replace("</Piece>", "</Piece><Piece NumberOfPoints='0' NumberOfCells='1'/>");
    assert_eq!(message(&twice), "square: the file holds 2 pieces; an unstructured grid of one piece is read");
}

#[test]
fn broken_formats_name_the_line() {
    assert_eq!(
        changed(LEGACY, "CELL_TYPES 3", "CELL_TYPES three"),
        "square: line 14: expected the number of types, found \" three\""
    );
    assert_eq!(changed(LEGACY, "1 1 0\n", "1 x 0\n"), "square: array \"POINTS\": \"x\" is no such number");
    assert_eq!(
        changed(LEGACY, "POINTS 4", "POINTS 400000000000"),
        "square: array \"POINTS\": the file ends before its 1200000000000 numbers do"
    );
    assert_eq!(
        changed(LEGACY, "int 1", "string 1"),
        "square: line 19: expected a type of numbers, found \" string 1\""
    );
    assert_eq!(
        changed(XML, "</Cells>", ""),
        "square: line 16: expected the end of the innermost element, found \"</Piece>\""
    );
    assert_eq!(
        changed(XML, "Name=\"offsets\"", "Name=offsets"),
        "square: line 12: expected = and the value of Name in quotation marks, found \"offsets format=\\\"ascii\\\">3 6 8</DataArray>\""
    );
    assert_eq!(
        changed(XML, "<Cells>", "<Cells"),
        "square: line 11: expected a name, found \"<DataArray type=\\\"Int64\\\" Name=\\\"connectivi…\""
    );
}

// Wherever a file breaks off, nothing is read.
#[test]
fn truncated_files() {
    for file in [LEGACY, XML] {
        // Without data there are no regions, but there is a mesh.
        let needed = if file == LEGACY { file.find("CELL_DATA").unwrap() - 1 } else { file.len() - 1 };
        for length in 0..needed {
            assert!(
                VtkReader::new().from_bytes::<2>("square", &file.as_bytes()[..length]).is_err(),
                "{length}"
            );
        }
    }
    assert_eq!(message(LEGACY.split("CELL_TYPES").next().unwrap()), "square: there is no section CELL_TYPES");
    assert_eq!(
        message(&LEGACY[..LEGACY.len() - 3]),
        "square: array \"region\": the file ends before its 3 numbers do"
    );
}

// Data that were read have the sizes of the first sections.
#[test]
fn sections_that_stand_twice() {
    let again = "CELLS 4 15\n3 0 1 2  3 0 2 3  2 0 1  2 1 2\nCELL_TYPES 4\n5 5 3 3\n";
    assert_eq!(message(&format!("{LEGACY}{again}")), "square: array \"CELLS\": the section stands twice");
    let points = "POINTS 1 double\n0 0 0\n";
    assert_eq!(message(&format!("{LEGACY}{points}")), "square: array \"POINTS\": the section stands twice");
}

#[test]
fn arrays() {
    assert_eq!(
        changed(XML, "Name=\"types\"", "Name=\"kinds\""),
        "square: there is no array \"types\" in <Cells>"
    );
    assert_eq!(
        changed(XML, ">3 6 8<", ">3 6<"),
        "square: array \"offsets\": it has 2 values where 3 times 1 are needed"
    );
    assert_eq!(
        changed(XML, "UInt8", "Float32"),
        "square: array \"types\": its numbers are not of an integer type"
    );
    assert_eq!(changed(XML, "UInt8", "Int7"), "square: array \"types\": its type \"Int7\" is not known");
    assert_eq!(
        changed(XML, "format=\"ascii\">3", "format=\"binary\">3"),
        "square: array \"offsets\": its data break off, or are not in the encoding that the file states"
    );
    assert_eq!(
        changed(XML, "format=\"ascii\">3", "format=\"appended\" offset=\"7\">3"),
        "square: array \"offsets\": its offset lies behind the appended data"
    );
    assert_eq!(
        changed(XML, "byte_order", "compressor=\"vtkLZ4DataCompressor\" byte_order"),
        "square: there is no way to read compressor = \"vtkLZ4DataCompressor\""
    );
    assert_eq!(
        changed(LEGACY, "CELL_DATA 3", "CELL_DATA 2"),
        "square: array \"CELL_DATA\": it is for 2 where there are 3"
    );
    // Eight bytes are announced in a header of four, zlib's data are none.
    let packed = XML.replace("byte_order", "compressor=\"vtkZLibDataCompressor\" byte_order");
    assert_eq!(
        changed(
            &packed,
            "format=\"ascii\">3 6 8<",
            "format=\"binary\">AQAAAAgAAAAIAAAACAAAAA==AAAAAAAAAAA=<"
        ),
        "square: array \"offsets\": its data are not what zlib makes of as many bytes as its header states"
    );
}

#[test]
fn cells_and_points() {
    assert_eq!(
        changed(XML, "0 1 2 0 2 3", "0 1 2 0 2 9"),
        "square: cell 1 names point 9, but there are 4 points (numbered from 0)"
    );
    assert_eq!(
        changed(LEGACY, "3 0 2 3", "3 0 -2 3"),
        "square: cell 1 names point -2, but there are 4 points (numbered from 0)"
    );
    assert_eq!(changed(LEGACY, "3 0 2 3", "3 0 2 2"), "square: cell 1 names point 2 twice");
    assert_eq!(
        changed(LEGACY, "1 1 0\n", "1 nan 0\n"),
        "square: point 2 has a coordinate that is not finite: [1.0, NaN, 0.0]"
    );
    assert_eq!(
        changed(XML, ">3 6 8<", ">3 2 8<"),
        "square: cell 1 takes the entries from 3 to 2 of the connectivity, which has 8"
    );
    let known = "vertices, lines, triangles, quadrilaterals, tetrahedra, hexahedra, wedges and pyramids of first and second \
                 order, with all their points, are known";
    assert_eq!(
        changed(XML, "5 5 3", "5 77 3"),
        format!("square: cell 1 is of type 77 and has 3 points; {known}")
    );
    assert_eq!(
        changed(XML, "5 5 3", "5 9 3"),
        format!("square: cell 1 is of type 9 and has 3 points; {known}")
    );
    let one_region = LEGACY.replace("1 2 7", "1 1 7");
    assert!(
        changed(&one_region, "3 0 2 3", "3 0 3 2").starts_with("square: cell 1 is inverted or degenerate")
    );
    assert_eq!(changed(&one_region, "3 0 2 3", "3 2 1 0"), "square: cells 0 and 1 are the same cell");
    assert_eq!(
        changed(LEGACY, "0 1 0\n", "0 1 0.5\n"),
        "square: points 0 and 3 of a plane mesh have z = 0 and z = 0.5; all must be equal"
    );
    assert_eq!(
        with::<3>(&VtkReader::new(), LEGACY),
        "square: the cells have two dimensions (cell 0 is a triangle), but a mesh in three dimensions was asked for"
    );
    let edges =
        XML.replace("0 1 2 0 2 3 0 1", "0 1 1 2 2 3").replace("3 6 8", "2 4 6").replace("5 5 3", "3 3 3");
    assert_eq!(message(&edges), "square: the file has no cells");
    let seven = XML
        .replace("NumberOfPoints=\"4\"", "NumberOfPoints=\"7\"")
        .replace("0 0 0 1 0 0 1 1 0 0 1 0", "0 0 0 1 0 0 1 1 0 0 1 0 0.5 0 0 1 0.5 0 0.5 1 0");
    let seven = seven.replace("0 1 2 0 2 3 0 1", "0 1 2 4 5 6 3 0 1 1 2").replace("3 6 8", "7 9 11");
    assert_eq!(
        changed(&seven, "5 5 3", "34 3 3"),
        "square: cell 0 is a biquadratic triangle; second-order cells are QUADRATIC_TRIANGLE, QUADRATIC_QUAD, \
         BIQUADRATIC_QUAD, QUADRATIC_TETRA, QUADRATIC_HEXAHEDRON or TRIQUADRATIC_HEXAHEDRON"
    );
}

#[test]
fn regions() {
    let reader = VtkReader::new();
    assert_eq!(
        with::<2>(&reader.clone().region_array("material"), XML),
        "square: there is no array \"material\" on the cells; the file has [\"region\"]"
    );
    assert_eq!(
        with::<2>(&reader.clone().name_cells(7, "steel"), XML),
        "square: the region \"steel\" would be empty: no cell has the number 7, and the numbers are [1, 2]"
    );
    assert_eq!(
        with::<2>(&reader.clone().name_facets(1, "wall"), XML),
        "square: the region \"wall\" would be empty: no facet has the number 1, and the numbers are [7]"
    );
    let reals = XML.replace("Int32\" Name", "Float64\" Name");
    assert_eq!(
        message(&reals.replace(">1 2 7<", ">1 2.5 7<")),
        "square: array \"region\" cannot hold regions: cell 1 has 2.5 in it, which is no whole number"
    );
    assert_eq!(message(&reals), "2 cells, [\"region 1\", \"region 2\", \"facets 7\"], []");
    // Both numbers have one name; a negative number is no region.
    let both = reader.clone().name_cells(1, "body").name_cells(2, "body");
    assert_eq!(with::<2>(&both, XML), "2 cells, [\"body\", \"facets 7\"], []");
    assert_eq!(changed(XML, ">1 2 7<", ">1 -1 -1<"), "2 cells, [\"region 1\"], []");
    assert_eq!(
        with::<2>(&reader.clone().name_cells(1, "wall").name_facets(7, "wall"), XML),
        "square: \"wall\" names a group of surfaces and one of curves; the name of a region stands for one of them"
    );
    assert_eq!(
        changed(XML, "0 1 2 0 2 3 0 1", "0 1 2 0 2 3 1 3"),
        "square: cell 2 of the group \"facets 7\" is not a facet of any cell"
    );
    let notes = |text: &str| -> Vec<String> {
        let read = reader.from_bytes::<2>("square", text.as_bytes()).unwrap();
        read.notes.iter().map(ToString::to_string).collect()
    };
    assert_eq!(
        notes(&XML.replace("Name=\"region\"", "Name=\"other\"")),
        ["1 cells that may be facets belong to no region and are left out"]
    );
    let clockwise = XML.replace("0 1 2 0 2 3 0 1", "0 2 1 0 3 2 0 1");
    assert_eq!(
        notes(&clockwise),
        [
            "the 1 cells of region 1 ran clockwise and were turned",
            "the 1 cells of region 2 ran clockwise and were turned"
        ]
    );
}
