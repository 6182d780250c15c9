// Half of a cylinder (its lower half) and of the block on which it lies, fine at the contact and coarser with the distance. The origin is
// the point where they touch. Groups: cylinder, block (surfaces), round, top (within 15 mm), axis, cut (of the cylinder at its centre), base.
fine = 2.5e-4; R = 0.05;
Point(1) = {0, -0.2, 0}; Point(2) = {0.1, -0.2, 0}; Point(3) = {0.1, 0, 0}; Point(4) = {0.015, 0, 0}; Point(5) = {0, 0, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 1};
Curve Loop(1) = {1 : 5}; Plane Surface(1) = {1};
Point(6) = {0, 0, 0}; Point(7) = {R * Sin(0.3), R * (1 - Cos(0.3)), 0}; Point(8) = {R, R, 0}; Point(9) = {0, R, 0};
Circle(6) = {6, 9, 7}; Circle(7) = {7, 9, 8}; Line(8) = {8, 9}; Line(9) = {9, 6};
Curve Loop(2) = {6 : 9}; Plane Surface(2) = {2};
Field[1] = MathEval;
Field[1].F = Sprintf("%g * Max(1, Sqrt(x^2 + y^2) / 0.008)", fine);
Field[2] = MathEval;
Field[2].F = Sprintf("%g * Max(1, Sqrt(x^2 + y^2) / 0.008)", 1.37 * fine);
Field[3] = Restrict; Field[3].InField = 1; Field[3].SurfacesList = {2}; Field[3].CurvesList = {6, 7, 8, 9};
Field[4] = Restrict; Field[4].InField = 2; Field[4].SurfacesList = {1}; Field[4].CurvesList = {1, 2, 3, 4, 5};
Field[5] = Min; Field[5].FieldsList = {3, 4};
Background Field = 5;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0;
Physical Surface("block") = {1}; Physical Surface("cylinder") = {2};
Physical Curve("top") = {4}; Physical Curve("round") = {6}; Physical Curve("axis") = {5, 9}; Physical Curve("cut") = {8}; Physical Curve("base") = {1};
