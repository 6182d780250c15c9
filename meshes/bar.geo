// Bar of length 10 m, upright, as a strip 1 m wide with its lower end on the origin's height; structured, four columns of
// triangles that mirror each other, so that nothing makes it bend. The element size is that along the bar.
// Groups: body (surface), contact (the lower end), free (the sides and the upper end), top (the upper end).
length = 10;
width = 1;
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
Transfinite Curve{1, 3} = 5;
Transfinite Surface{1} = {1, 2, 3, 4} Alternated;

Physical Surface("body") = {1};
Physical Curve("contact") = {1};
Physical Curve("free") = {2, 3, 4};
Physical Curve("top") = {3};
