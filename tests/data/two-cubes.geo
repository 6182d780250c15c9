// Two unit cubes on each other, 0.05 apart, of elements of the sizes h1 and h2. Groups: lower, upper (volumes), floor, below (upper side of
// the lower cube), above (lower side of the upper one), top, sides along x and along y (surfaces).
SetFactory("OpenCASCADE");
If (!Exists(h1)) h1 = 0.4; EndIf
If (!Exists(h2)) h2 = 0.3; EndIf
Box(1) = {0, 0, 0, 1, 1, 1}; Box(2) = {0, 0, 1.05, 1, 1, 1};
MeshSize{PointsOf{Volume{1};}} = h1; MeshSize{PointsOf{Volume{2};}} = h2;
Physical Volume("lower") = {1}; Physical Volume("upper") = {2};
Physical Surface("floor") = {5}; Physical Surface("below") = {6}; Physical Surface("above") = {11}; Physical Surface("top") = {12};
Physical Surface("x sides") = {1, 2, 7, 8}; Physical Surface("y sides") = {3, 4, 9, 10};
