// Two bars of 1 m and the height 0.02 m, end to end, 1e-5 m apart, with 3 and 4 elements across. Groups: left, right (surfaces), left end,
// right end (at the gap), held (the far end of the left bar), sides (all long sides).
along = 200; height = 0.02; gap = 1e-5;
Point(1) = {-1, 0, 0}; Point(2) = {0, 0, 0}; Point(3) = {0, height, 0}; Point(4) = {-1, height, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Point(5) = {gap, 0, 0}; Point(6) = {1 + gap, 0, 0}; Point(7) = {1 + gap, height, 0}; Point(8) = {gap, height, 0};
Line(5) = {5, 6}; Line(6) = {6, 7}; Line(7) = {7, 8}; Line(8) = {8, 5};
Curve Loop(2) = {5, 6, 7, 8}; Plane Surface(2) = {2};
Transfinite Curve{1, 3, 5, 7} = along + 1;
Transfinite Curve{2, 4} = 3 + 1; Transfinite Curve{6, 8} = 4 + 1;
Transfinite Surface{1}; Transfinite Surface{2};
Physical Surface("left") = {1}; Physical Surface("right") = {2};
Physical Curve("left end") = {2}; Physical Curve("right end") = {8}; Physical Curve("held") = {4};
Physical Curve("sides") = {1, 3, 5, 7};
