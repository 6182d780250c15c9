// A cube of 25.4 mm above the middle of a plate of 254 x 254 x 25.4 mm, 0.1 mm apart. Groups: cube, plate (volumes), under, over (surfaces).
SetFactory("OpenCASCADE");
a = 0.0254; gap = 1e-4;
Box(1) = {-5 * a, -5 * a, -a, 10 * a, 10 * a, a};
Box(2) = {-a / 2, -a / 2, gap, a, a, a};
Field[1] = MathEval;
Field[1].F = Sprintf("Max(%g, Min(%g, 0.25 * Sqrt(x^2 + y^2)))", a / 4, a);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0;
Physical Volume("plate") = {1}; Physical Volume("cube") = {2};
Physical Surface("over") = {6}; Physical Surface("under") = {11};
