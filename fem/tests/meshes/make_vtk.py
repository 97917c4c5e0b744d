"""Makes the .vtu and .vtk files of this directory with meshio and with VTK from the .msh files next to them.

    python3 -m venv venv && venv/bin/pip install -r requirements_vtk.txt && venv/bin/python make_vtk.py

Physical groups are the array "gmsh:physical". The Lagrange cells are VTK's own source of a cube.
"""

import pathlib

import meshio
import vtk

HERE = pathlib.Path(__file__).parent


def with_meshio(source, name, **options):
    mesh = meshio.read(HERE / f"{source}.msh")
    # Names of groups and sets have no place in these files.
    mesh.field_data, mesh.cell_sets = {}, {}
    meshio.write(HERE / name, mesh, **options)


def with_vtk(source, name, set_options):
    """What meshio wrote, read by VTK and written again."""
    temporary = HERE / "temporary.vtu"
    with_meshio(source, temporary.name)
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(temporary))
    reader.Update()
    temporary.unlink()
    write(reader.GetOutput(), name, set_options)


def write(grid, name, set_options):
    legacy = name.endswith(".vtk")
    writer = vtk.vtkUnstructuredGridWriter() if legacy else vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(str(HERE / name))
    writer.SetInputData(grid)
    set_options(writer)
    assert writer.Write() == 1


def lagrange(kind, name):
    source = vtk.vtkCellTypeSource()
    source.SetCellType(kind)
    source.SetCellOrder(2)
    source.SetBlocksDimensions(1, 1, 1)
    source.Update()
    write(source.GetOutput(), name, lambda writer: writer.SetDataModeToAscii())


def appended_raw(writer):
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToZLib()
    # Several blocks, the last one shorter.
    writer.SetBlockSize(128)


def appended_base64(writer):
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOn()
    writer.SetCompressorTypeToNone()
    writer.SetHeaderTypeToUInt64()


def inline_big(writer):
    writer.SetDataModeToBinary()
    writer.SetByteOrderToBigEndian()
    writer.SetCompressorTypeToZLib()


def main():
    with_meshio("plate_2.2", "plate_meshio_text.vtu", binary=False)
    with_meshio("plate_2.2", "plate_meshio_base64.vtu", compression=None)
    with_meshio("plate_2.2", "plate_meshio_zlib.vtu", compression="zlib")
    with_meshio("plate_2.2", "plate_meshio_42.vtk", file_format="vtk42", binary=False)
    with_meshio("plate_2.2", "plate_meshio_51.vtk", file_format="vtk51", binary=True)
    with_vtk("house_4.1", "house_vtk_raw.vtu", appended_raw)
    with_vtk("house_4.1", "house_vtk_base64.vtu", appended_base64)
    with_vtk("house_4.1", "house_vtk_text.vtk", lambda writer: writer.SetFileTypeToASCII())
    with_vtk("hexahedra_2.2", "hexahedra_vtk_big.vtu", inline_big)
    with_vtk("hexahedra_2.2", "hexahedra_vtk_binary.vtk", lambda writer: writer.SetFileTypeToBinary())
    with_meshio("tetrahedra_4.1", "tetrahedra_meshio_zlib.vtu", compression="zlib")
    lagrange(vtk.VTK_LAGRANGE_TRIANGLE, "triangles_vtk_lagrange.vtu")
    lagrange(vtk.VTK_LAGRANGE_QUADRILATERAL, "quadrilaterals_vtk_lagrange.vtu")
    lagrange(vtk.VTK_LAGRANGE_TETRAHEDRON, "tetrahedra_vtk_lagrange.vtu")
    lagrange(vtk.VTK_LAGRANGE_HEXAHEDRON, "hexahedra_vtk_lagrange.vtu")


if __name__ == "__main__":
    main()
