// The bars of two-bars.geo, of which the right one is twice as long.
l2 = 2;
Include "two-bars.geo";
