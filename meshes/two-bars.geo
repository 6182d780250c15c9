// Two bars of the lengths l1 and l2 and the height 0.1 m, 0.01 m apart, with n1 and n2 elements per metre and 3 and 4 across.
// Groups: left, right (surfaces), left end (of the left bar, at the right one), right end (of the right bar), held.
If (!Exists(l1)) l1 = 1; EndIf
If (!Exists(l2)) l2 = 1; EndIf
n1 = 240; n2 = 240; height = 0.1; gap = 0.01;
Point(1) = {-l1, 0, 0}; Point(2) = {0, 0, 0}; Point(3) = {0, height, 0}; Point(4) = {-l1, height, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Point(5) = {gap, 0, 0}; Point(6) = {gap + l2, 0, 0}; Point(7) = {gap + l2, height, 0}; Point(8) = {gap, height, 0};
Line(5) = {5, 6}; Line(6) = {6, 7}; Line(7) = {7, 8}; Line(8) = {8, 5};
Curve Loop(2) = {5, 6, 7, 8}; Plane Surface(2) = {2};
Transfinite Curve{1, 3} = l1 * n1 + 1; Transfinite Curve{5, 7} = l2 * n2 + 1;
Transfinite Curve{2, 4} = 3 + 1; Transfinite Curve{6, 8} = 4 + 1;
Transfinite Surface{1}; Transfinite Surface{2};
Physical Surface("left") = {1}; Physical Surface("right") = {2};
Physical Curve("left end") = {2}; Physical Curve("right end") = {8};
