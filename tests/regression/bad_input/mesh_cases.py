# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad meshes, in the plane and in space."""

import re

from case import (
    before, BODY, BOTTOM, Case, cube2, cube_elements, cube_points, edited, GEO, GROUPS, LINE, LINE_3, meshed, moved, moved_corner,
    PRISM, QUADRILATERAL, solid, SPACE_GROUPS, square2, square4, square_elements, square_points, TETRAHEDRON, TOP,
    TRIANGLE, TRIANGLE_6, with_element, with_space_element,
)


def mesh_file_cases() -> list[Case]:
    """Mesh files that are missing or cannot be read."""
    file, old, new = 'file = "square.msh"', square2(), square4()
    cut = re.compile("(?i)end of|ends|truncat|incomplete|cut short|missing|expected|read")
    geo = {"mesh_file": "square.geo", "edits": ((file, 'file = "square.geo"\nsize = 4'),)}
    return [
        edited("mesh missing", file, 'file = "nowhere.msh"', "mesh.file: ", "nowhere.msh", "cannot be read", "give the path",
               at="", earlier=True),
        edited("mesh missing, two ranks", file, 'file = "nowhere.msh"', "mesh.file: ", "nowhere.msh", at="", ranks=2),
        edited("mesh is a folder", file, 'file = "folder.msh"', "mesh.file: ", "folder.msh", "cannot be read", at="",
               prepare=lambda folder: (folder / "folder.msh").mkdir()),
        edited("mesh behind a link to itself", file, 'file = "loop/square.msh"', "mesh.file: ", "cannot be resolved", at="file =",
               prepare=lambda folder: (folder / "loop").symlink_to("loop")),
        edited("mesh of a name beyond all limits", file, f'file = "{"a" * 5000}.msh"', "mesh.file: ", "cannot be resolved", at="file ="),
        edited("mesh of another format", file, 'file = "square.stl"', 'mesh.file: found "square.stl"', "expected a file that ends in .geo, .msh, .step"),
        edited("split triangles", file, file + "\nsplit = true", "mesh.split has no effect", "triangles only", at=""),
        edited("split that is no flag", file, file + '\nsplit = "yes"', "mesh.split: found", "true or false", at="split ="),
        edited("size in millimetres", file, 'file = "square.geo"\nunit = "mm"\nsize = 8', "mesh.size: found 8 m",
               "at most 0.01 m for a body of 0.001 m",
               "in metres", at="", mesh_file="square.geo", mesh=GEO),
        edited("size of a mesh that is meshed", file, file + "\nsize = 4", "mesh.size: ", "no effect on a mesh",
               "use it with a geometry", at="size = 4"),
        meshed("geometry with a syntax error", GEO.replace("Line(2) = {2, 3};", "Line(2) = {2, 3;"), "line 6", "syntax",
               **geo),
        meshed("geometry with a syntax error, two ranks", GEO.replace("Line(2) = {2, 3};", "Line(2) = {2, 3;"),
               "line 6", "syntax", ranks=2, **geo),
        meshed("geometry with an unknown variable", GEO.replace("0.5, 0, 0", "width, 0, 0"), "width", **geo),
        meshed("geometry with an unknown point", GEO.replace("{2, 3}", "{2, 33}"), "33", **geo),
        meshed("geometry that includes a missing file", 'Include "points.geo";\n' + GEO, "points.geo", **geo),
        meshed("geometry that is empty", "", re.compile("no elements|empty"), **geo),
        meshed("geometry without surface", before(GEO, "Curve Loop"), "curve", "triangles", **geo),
        meshed("geometry without groups", before(GEO, "Physical"), "contact.on: ", '"bottom"', "curve groups of the file: boundary", **geo),
        meshed("geometry that ends gmsh", GEO + "Exit;\n", "gmsh stopped before the end of this file", "remove the command", "Exit", **geo),
        meshed("geometry that ends gmsh at once, two ranks", "Exit 3;\n" + GEO, "gmsh stopped", "Exit", ranks=2, **geo),
        meshed("geometry of a surface in space", GEO + "Rotate { {1, 0, 0}, {0, 0, 0}, Pi/2 } { Surface{1}; }\n",
               "plane z = 0", "1 m", "tetrahedra", **geo),
        meshed("mesh is empty", "", re.compile("empty|no elements|cannot read")),
        meshed("mesh is prose", "A square of eight triangles.\n" * 20, re.compile("cannot read|no elements|not a")),
        meshed("mesh is prose, two ranks", "A square of eight triangles.\n" * 20,
               re.compile("cannot read|no elements|not a"), ranks=2, earlier=True),
        meshed("mesh is binary", bytes(range(256)) * 16, re.compile("cannot read|no elements|not a")),
        # gmsh runs as a script what does not begin as a mesh; the folder of the case would then have one more file.
        *(meshed(f"mesh that begins with {what}", beginning + 'SystemCall "touch trace";\n' + end, "not a .msh file", "$MeshFormat",
                 **ranks)
          for what, beginning, end, ranks in (
              ("a command", "", old, {}), ("a command, two ranks", "", old, {"ranks": 2}),
              ("a command and an end", "", "$EndElements\n", {}),
              ("a comment of scripts", "// $MeshFormat\n", old, {}), ("a blank line", "\n", old, {}),
              ("blanks", " $MeshFormat\n", old, {}), ("an order mark", "\ufeff$MeshFormat\n", old, {}),
              ("more than $MeshFormat", "$MeshFormat;\n", old, {}), ("a post-processing view", "$View\n$EndView\n", old, {}))),
        meshed("mesh of an unknown version", new.replace("4.1 0 8", "9.7 0 8"), re.compile("9.7|version")),
        meshed("old mesh cut short in the nodes", before(old, "$Nodes", 6), cut, earlier=True),
        meshed("old mesh cut short after the nodes", before(old, "$Elements"), cut),
        meshed("old mesh cut short in the elements", before(old, "$Elements", 6), cut),
        meshed("old mesh cut short in a row", before(old, "$Elements", 6).rstrip()[:-2], cut),
        meshed("old mesh cut short in its last number", old[: old.index("\n$EndElements") - 1], cut),
        meshed("mesh cut short in the entities", before(new, "$Entities", 3), cut),
        meshed("mesh cut short in the nodes", before(new, "$Nodes", 15), cut),
        meshed("mesh cut short after the nodes", before(new, "$Elements"), cut),
        meshed("mesh cut short in the elements", before(new, "$Elements", 6), cut, earlier=True),
        meshed("mesh cut short in the elements, two ranks", before(new, "$Elements", 6), cut, ranks=2),
        meshed("mesh with fewer elements than announced", old.replace("$Elements\n16\n", "$Elements\n20\n"), cut, never=("/proc",)),
    ]


def mesh_content_cases() -> list[Case]:
    """Meshes that are no plane meshes of straight triangles with groups."""
    triangle = (TRIANGLE, BODY, 1)
    return [
        meshed("no groups", square2(groups=(), elements=[(kind, 0, entity, nodes) for kind, _, entity, nodes in
                                                         square_elements()]), "contact.on: ", '"bottom"',
               "curve groups of the file: boundary"),
        meshed("surface without a group", square2(points=[*square_points(), (0.0, -1.0, 0.0)], elements=with_element(
            (TRIANGLE, 0, 7, (1, 10, 2)))), "surface 7", "no physical group", "Physical Surface"),
        edited("misspelt group of contact", 'on = "bottom"', 'on = "botom"', "contact.on: ", "square.msh", '"botom"',
               'did you mean "bottom"?', "bottom, side, top", at="", earlier=True),
        edited("misspelt group of contact, two ranks", 'on = "bottom"', 'on = "botom"', "contact.on: ",
               'did you mean "bottom"?', at="", ranks=2),
        edited("misspelt group of a clamp", 'on = "top"', 'on = "topp"', "clamp", "square.msh", '"topp"',
               'did you mean "top"?', "bottom, side, top", at="", verb="info"),
        edited("misspelt group of the second clamp", '[[clamp]]\non = "top"',
               '[[clamp]]\non = "top"\n\n[[clamp]]\non = "sid"', "clamp[1].on: ", '"sid"', 'did you mean "side"?', at=""),
        edited("surface as a clamp", 'on = "top"', 'on = "body"', "clamp", '"body"', "dimension 2", "curve", at=""),
        edited("surface as contact, check", 'on = "bottom"', 'on = "body"', "contact.on: ", '"body"', "dimension 2",
               "bottom, side, top", at="", verb="check"),
        meshed("group that is only a name", square2(groups=(*GROUPS, (1, 5, "nothing"))), "contact.on: ", '"nothing"',
               "elements", edits=(('on = "bottom"', 'on = "nothing"'),)),
        meshed("group of a curve without elements", square4(empty_curve=True), "contact.on: ", '"nothing"',
               "has no elements", edits=(('on = "bottom"', 'on = "nothing"'),)),
        Case("a solid beside a plane body", ("contact.obstacle.point: ", "the mesh is 3-dimensional"), earlier=True, mesh=square2(
            points=[*square_points(), (0.0, 0.0, 1.0)], groups=(*GROUPS, (3, 9, "solid")),
            elements=with_element((TETRAHEDRON, 9, 1, (1, 2, 4, 10))))),
        meshed("mesh of curves", square2(elements=[e for e in square_elements() if e[0] == LINE]), "curve",
               "triangles"),
        meshed("mesh of a point", square2(elements=[(15, 0, 1, (1,))]), "point", "triangles"),
        meshed("mesh without elements", square2(elements=[]), "no elements"),
        meshed("quadrilaterals", square2(elements=[(QUADRILATERAL, BODY, 1, (1, 2, 5, 4))]), "Quadrilateral",
               "straight triangles", "mesh.split = true"),
        meshed("a quadrilateral among triangles", square2(points=[*square_points(), (1.0, 0.0, 0.0), (1.0, 0.5, 0.0)],
                                                          elements=with_element((QUADRILATERAL, BODY, 1, (3, 10, 11, 6)))),
               "Quadrilateral", "straight triangles"),
        meshed("curved triangles", square2(points=moved(5, (0.1, 0.6, 0.0)), elements=[(TRIANGLE_6, BODY, 1, (1, 3, 7, 2, 5, 4))]),
               "curved elements", "mesh.degree = 1", edits=(('file = "square.msh"', 'file = "square.msh"\ndegree = 2'),)),
        meshed("edges of second order", square2(elements=[e for e in square_elements() if e[1] != BOTTOM] +
                                                [(LINE_3, BOTTOM, BOTTOM, (1, 3, 2))]), "contact.on: ", "which belongs to no triangle"),
        meshed("node off the plane", square2(points=moved(5, (0.0, 0.5, 0.1))), "plane z = 0", "0.1 m", "tetrahedra"),
        meshed("node off the plane, two ranks", square2(points=moved(5, (0.0, 0.5, 0.1))), "plane z = 0", "0.1 m",
               ranks=2),
        meshed("mesh in another plane", square2(points=[(x, y, 1.0) for x, y, _ in square_points()]), "plane z = 0",
               "1 m"),
        meshed("triangle on a line", square2(elements=with_element((*triangle, (1, 2, 3)))), "(-0.5, 0)", "zero area"),
        meshed("triangle with a corner twice", square2(elements=with_element((*triangle, (1, 2, 2)))), "(-0.5, 0)",
               "zero area"),
        meshed("two nodes in one place", square2(points=moved(5, (0.5, 0.5, 0.0))), "zero area"),
        meshed("coordinate that is no number", square2(points=moved(5, (float("nan"), 0.5, 0.0))), "node 5", "nan",
               "finite"),
        meshed("infinite coordinate", square2(points=moved(5, (0.0, float("inf"), 0.0))), "node 5", "inf", "finite"),
        meshed("element with a node that is missing", square2(elements=with_element((*triangle, (1, 2, 77)))), "77"),
        meshed("edge with a node that is missing", square2(elements=with_element((LINE, BOTTOM, BOTTOM, (3, 77)))),
               "77"),
        meshed("edge with a node of no triangle", square2(points=[*square_points(), (1.0, 0.0, 0.0)], elements=with_element(
            (LINE, BOTTOM, BOTTOM, (3, 10)))), "contact.on: ", '"bottom"', "the edge at (0.5, 0)", "no triangle"),
        meshed("edge of no triangle", square2(elements=with_element((LINE, BOTTOM, BOTTOM, (2, 9)))), "bottom",
               "triangle"),
        meshed("group of edges of no triangle", square2(elements=[e for e in square_elements() if e[1] != BOTTOM] + [
            (LINE, BOTTOM, BOTTOM, (1, 3))]), "bottom", "triangle"),
        meshed("triangle twice", square2(elements=with_element((*triangle, (1, 2, 5)))), re.compile("twice|share|overlap")),
        meshed("triangles that overlap", square2(points=moved(5, (0.75, 0.5, 0.0))), "two triangles", "the edge at (",
               "overlap", "either side"),
        meshed("group named as the number of another", square2(groups=((2, BODY, "body"), (1, TOP, "top"), (1, BOTTOM, "4"))),
               "contact.on: ",
               '"4"', "the unnamed group with this number", "give the unnamed group a name", edits=(('on = "bottom"', 'on = "4"'),)),
        edited("all contact nodes clamped", 'on = "bottom"', 'on = "top"', "contact.on: ", '"top"', "clamped",
               "nodes that can move", at="", earlier=True),
        edited("all contact nodes clamped, two ranks", 'on = "bottom"', 'on = "top"', "contact.on: ", "clamped", at="",
               ranks=2),
        edited("body inside the obstacle", "point = [0, -0.1]", "point = [0, 0.25]", "contact: ", "node at", ", 0",
               "0.25 m inside the obstacle", "start outside", at="", earlier=True),
        edited("body inside the obstacle, two ranks", "point = [0, -0.1]", "point = [0, 0.25]", "contact: ",
               "0.25 m inside", at="", ranks=2),
        edited("body moved into the obstacle", 'displacement = ["0", "0"]', 'displacement = ["0", "-0.2*(1 - y)"]',
               "contact: ", "node at", "0.1 m inside the obstacle", at=""),
        edited("body in the obstacle by rounding", "point = [0, -0.1]", "point = [0, 1e-9]", "contact: ", "1e-09 m inside",
               "as do all 3 candidates",
               'contact.initial = "project"', at="", never=("reversed",)),
        Case("normal that points into the obstacle", ("contact: ", "inside the obstacle", "normal"),
             edits=(("normal = [0, 1]", "normal = [0, -1]"),)),
    ]


def space_cases() -> list[Case]:
    """Meshes of tetrahedra that are wrong, and vectors that do not fit one."""
    cube, tetrahedron = cube2(), (TETRAHEDRON, BODY, 1)
    outside, beyond = (1.5, 0.0, 0.5), (0.0, 0.0, 2.0)
    found, clamped_bottom = ("found 2 components", "3", "3-dimensional"), (('on = "bottom"', 'on = "top"'),)
    hexahedron = (5, BODY, 1, (1, 2, 4, 3, 5, 6, 8, 7))
    no_bottom = [e for e in cube_elements() if e[1] != BOTTOM]
    return [
        solid("body load of two components in space", cube, "load.body", *found,
              edits=(('body = ["0", "0", "-9.81"]', 'body = ["0", "-9.81"]'),)),
        solid("velocity of two components in space, two ranks", cube, "initial.velocity", *found, ranks=2,
              edits=(('velocity = ["0", "0", "0"]', 'velocity = ["0", "0"]'),)),
        solid("desired control of two components in space", cube, "objective.desired.control", *found, verb="optimize",
              edits=(('control = ["0", "0", "-1"]', 'control = ["0", "-1"]'),), earlier=True),
        solid("bound of two components in space", cube, "control.lower", *found,
              edits=(("lower = -2.0", "lower = [-2, -2]"),)),
        solid("plane obstacle of a solid", cube, "contact.obstacle.point", *found,
              edits=(("point = [0, 0, -0.1], normal = [0, 0, 1]", "point = [0, -0.1], normal = [0, 1]"),)),
        solid("flat tetrahedron", cube2(elements=with_space_element((*tetrahedron, (1, 2, 4, 3)))), "(-0.5, -0.5, 0)",
              "zero volume", "tetrahedra"),
        solid("tetrahedron with a corner twice", cube2(elements=with_space_element((*tetrahedron, (1, 2, 6, 6)))),
              "(-0.5, -0.5, 0)", "zero volume"),
        solid("two corners in one place", cube2(points=moved_corner(7, (-0.5, 0.5, 0.0))), "zero volume"),
        solid("tetrahedron twice", cube2(elements=with_space_element((*tetrahedron, (8, 4, 2, 1)))), "the tetrahedron at",
              "twice"),
        solid("tetrahedra that overlap", cube2(points=moved_corner(3, (1.5, -1.0, 0.0))), "two tetrahedra", "the face at (",
              "overlap", "either side"),
        solid("tetrahedra that overlap, two ranks", cube2(points=moved_corner(3, (1.5, -1.0, 0.0))), "overlap", ranks=2),
        solid("face of three tetrahedra", cube2(points=[*cube_points(), outside], elements=with_space_element(
            (*tetrahedron, (1, 4, 8, 9)))), "more than two tetrahedra", "the face at (-0.5, -0.5, 0)"),
        solid("hexahedra", cube2(elements=[hexahedron]), "Hexahedron", "straight tetrahedra"),
        solid("a prism among tetrahedra", cube2(points=[*cube_points(), outside, beyond], elements=with_space_element(
            (PRISM, BODY, 1, (2, 4, 9, 6, 8, 10)))), "Prism", "straight tetrahedra"),
        solid("quadrilaterals for a side", cube2(elements=[*no_bottom, (QUADRILATERAL, BOTTOM, BOTTOM, (1, 2, 4, 3))]),
              "contact.on: ", "Quadrilateral", "straight triangles"),
        solid("face of no tetrahedron", cube2(elements=[*no_bottom, (TRIANGLE, BOTTOM, BOTTOM, (1, 2, 3))]),
              "the face at (-0.5, -0.5, 0)", '"bottom"', "the face at (-0.5, -0.5, 0), which belongs to no tetrahedron"),
        solid("face with a node that is missing", cube2(elements=with_space_element((TRIANGLE, TOP, TOP, (5, 6, 77)))),
              "77"),
        solid("face with a node of no tetrahedron", cube2(points=[*cube_points(), beyond], elements=with_space_element(
            (TRIANGLE, TOP, TOP, (5, 6, 9)))), "clamp", '"top"', "the face at (-0.5, -0.5, 1)", "no tetrahedron"),
        solid("tetrahedron with a node that is missing", cube2(elements=with_space_element((*tetrahedron, (1, 2, 4, 77)))),
              "77"),
        solid("corner that is no number", cube2(points=moved_corner(7, (float("nan"), 0.5, 1.0))), "node 7", "nan",
              "finite"),
        solid("volume without a group", cube2(points=[*cube_points(), beyond], elements=with_space_element(
            (TETRAHEDRON, 0, 7, (5, 6, 8, 9)))), "volume 7", "no physical group", "Physical Volume"),
        solid("surfaces of a cube without its volume", cube2(elements=[e for e in cube_elements() if e[0] == TRIANGLE]),
              "plane z = 0", "1 m", "tetrahedra"),
        solid("misspelt surface of a clamp", cube, "clamp", '"topp"', 'did you mean "top"?', "surface groups", "bottom, top",
              edits=(('on = "top"', 'on = "topp"'),), earlier=True),
        solid("volume as a clamp", cube, "clamp", '"body"', "dimension 3", "surface groups",
              edits=(('on = "top"', 'on = "body"'),)),
        solid("curve as contact of a solid", cube2(groups=(*SPACE_GROUPS, (1, 9, "rim")), elements=with_space_element(
            (LINE, 9, 9, (1, 2)))), "contact.on", '"rim"', "dimension 1", "surface groups",
              edits=(('on = "bottom"', 'on = "rim"'),)),
        solid("all contact nodes of a solid clamped, two ranks", cube, "contact.on: ", "clamped", edits=clamped_bottom,
              ranks=2),
        solid("solid inside the obstacle", cube, "contact: ", "node at", ", 0)", "0.25 m inside the obstacle",
              edits=(("point = [0, 0, -0.1]", "point = [0, 0, 0.25]"),), earlier=True),
        solid("mesh of a solid cut short", before(cube, "$EndElements"), "cube.msh", re.compile("end of a section")),
    ]
