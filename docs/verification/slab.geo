// Slab 1 m thick and 2 m wide in both directions, with its lower side on the origin's height; structured, by numbers of elements.
// Groups: body (volume), bottom (the contact candidates).
width = 2;
across = 8;    // elements along each side
through = 32;  // elements through the thickness
Point(1) = {-width / 2, -width / 2, 0};
Point(2) = {width / 2, -width / 2, 0};
Point(3) = {width / 2, width / 2, 0};
Point(4) = {-width / 2, width / 2, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve{1, 2, 3, 4} = across + 1;
Transfinite Surface{1} = {1, 2, 3, 4} Left;
Extrude {0, 0, 1} { Surface{1}; Layers{through}; }

Physical Volume("body") = {1};
Physical Surface("bottom") = {1};
