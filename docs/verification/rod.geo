// The rod of rod.toml: diameter 25.4 mm, length 254 mm, 48 layers. Its section is a polygon of 12 sides that has the circle's area.
// Groups: body (volume), end (the lower end, the contact candidates), top (the upper end).
length = 0.254;
sides = 12;
radius = 0.0127 * Sqrt(2 * Pi / sides / Sin(2 * Pi / sides));
For i In {0 : sides - 1}
  Point(i + 1) = {radius * Cos(2 * Pi * i / sides), radius * Sin(2 * Pi * i / sides), 0};
EndFor
For i In {1 : sides}
  Line(i) = {i, i % sides + 1};
EndFor
Curve Loop(1) = {1 : sides};
Plane Surface(1) = {1};
Transfinite Curve{1 : sides} = 2;
upper[] = Extrude {0, 0, length} { Surface{1}; Layers{48}; };

Physical Volume("body") = {upper[1]};
Physical Surface("end") = {1};
Physical Surface("top") = {upper[0]};
