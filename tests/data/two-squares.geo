// Two unit squares on each other, `gap` apart, with n1 and n2 elements along each side. Groups: lower, upper (surfaces),
// floor, below (upper side of the lower square), above (lower side of the upper one), top, sides (curves).
If (!Exists(n1)) n1 = 5; EndIf
If (!Exists(n2)) n2 = 7; EndIf
If (!Exists(gap)) gap = 0.05; EndIf
Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Point(3) = {1, 1, 0}; Point(4) = {0, 1, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Point(5) = {0, 1 + gap, 0}; Point(6) = {1, 1 + gap, 0}; Point(7) = {1, 2 + gap, 0}; Point(8) = {0, 2 + gap, 0};
Line(5) = {5, 6}; Line(6) = {6, 7}; Line(7) = {7, 8}; Line(8) = {8, 5};
Curve Loop(2) = {5, 6, 7, 8}; Plane Surface(2) = {2};
Transfinite Curve{1, 2, 3, 4} = n1 + 1; Transfinite Curve{5, 6, 7, 8} = n2 + 1;
Physical Surface("lower") = {1}; Physical Surface("upper") = {2};
Physical Curve("floor") = {1}; Physical Curve("below") = {3}; Physical Curve("above") = {5};
Physical Curve("top") = {7}; Physical Curve("sides") = {2, 4, 6, 8};
