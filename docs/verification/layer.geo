// Layer 1 m thick and 5 m wide, with its lower side on the origin's height; structured, with equal triangles, so that a motion which does
// not depend on x stays so. The element size is that through the thickness. Groups: body (surface), bottom (the contact candidates).
width = 5;
across = 20;   // elements
Point(1) = {-width / 2, 0, 0};
Point(2) = {width / 2, 0, 0};
Point(3) = {width / 2, 1, 0};
Point(4) = {-width / 2, 1, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve{1, 3} = across + 1;
Transfinite Surface{1} = {1, 2, 3, 4} Left;

Physical Surface("body") = {1};
Physical Curve("bottom") = {1};
