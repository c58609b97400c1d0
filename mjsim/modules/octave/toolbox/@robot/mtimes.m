function r = mtimes(a, b)
% MTIMES  An arm with the links of one after those of the other.
  r = a;
  r.links = [a.links, b.links];
  r.name = [a.name ' * ' b.name];
  r.tool = b.tool;
end
