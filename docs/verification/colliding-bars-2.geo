// The bars of colliding-bars.geo, of which the right one is twice as long.
l2 = 2;
Include "colliding-bars.geo";
