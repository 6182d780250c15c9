// Upright strip of `length` and `width` (m) with its lower end on the origin's height; structured, two columns of triangles, which
// mirror each other so that nothing bends the strip. The element size is that along the strip. Included by other meshes.
// Groups: body (surface), bottom (the lower end), top (the upper end).
Point(1) = {-width / 2, 0, 0};
Point(2) = {width / 2, 0, 0};
Point(3) = {width / 2, length, 0};
Point(4) = {-width / 2, length, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve{1, 3} = 3;
Transfinite Surface{1} = {1, 2, 3, 4} Alternated;

Physical Surface("body") = {1};
Physical Curve("bottom") = {1};
Physical Curve("top") = {3};
