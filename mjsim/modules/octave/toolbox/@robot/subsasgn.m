function r = subsasgn(r, s, value)
% SUBSASGN  Sets fields of an arm: r.tool = T, r.name = 'arm', r.links(2).m = 3, r.link{2}.m = 3.
  name = s(1).subs;
  if strcmp(name, 'manufacturer'), name = 'manuf'; end
  if any(strcmp(name, {'links', 'link'}))
    if numel(s) > 1
      whole = subsref(r, s(1));
      value = subsasgn(whole, s(2:end), value);
    end
    if isstruct(value), value = num2cell(value); end
    links = [];
    for k = 1:numel(value), links = [links, mjsim_link(value{k})]; end
    r.links = links;
  elseif strcmp(name, 'mdh')
    for k = 1:numel(r.links), r.links(k).mdh = value; end
  elseif strcmp(name, 'offset')
    for k = 1:numel(r.links), r.links(k).offset = value(k); end
  elseif any(strcmp(name, {'qlim'}))
    for k = 1:numel(r.links), r.links(k).qlim = value(k, :); end
  elseif any(strcmp(name, {'name', 'manuf', 'comment', 'base', 'tool', 'gravity', 'q', 'plotopt', 'ikineType'}))
    if numel(s) > 1, value = subsasgn(r.(name), s(2:end), value); end
    if strcmp(name, 'gravity'), value = value(:); end
    r.(name) = value;
  elseif any(strcmp(name, {'plotopt3d', 'configuration', 'ikine'}))
    % Of pictures and names of solutions: nothing follows from them here.
  else
    error('an arm has no field ''%s''', name);
  end
end
