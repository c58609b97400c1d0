function varargout = subsref(r, s)
% SUBSREF  Fields of an arm, and its functions as methods: r.n, r.link{2}, r.fkine(q).
  if strcmp(s(1).type, '()')
    if numel(s) == 1, varargout{1} = r; else, [varargout{1:max(nargout, 1)}] = subsref(r, s(2:end)); end
    return
  end
  name = s(1).subs;
  switch name
    case 'manufacturer', v = r.manuf;
    case {'display', 'disp', 'print', 'char'}
      display(r);
      return
    case 'n', v = numel(r.links);
    case {'links', 'link'}
      v = r.links;
      if r.old
        for k = 1:numel(v), w(k) = mjsim_old(v(k)); end
        v = w;
      end
      if strcmp(name, 'link'), v = num2cell(v); end
    case 'dh'
      v = [[r.links.alpha]', [r.links.a]', [r.links.theta]', [r.links.d]', [r.links.sigma]'];
    case 'A'
      T = eye(4); c = mjsim_chain(r);
      for k = s(2).subs{1}
        q = s(2).subs{2}; turn = eye(4); value = q(min(k, numel(q))) + c.offset(k);
        if c.slide(k), turn(3, 4) = value; else, turn(1:2, 1:2) = [cos(value) -sin(value); sin(value) cos(value)]; end
        T = T * c.before(:, :, k) * turn * c.after(:, :, k);
      end
      varargout{1} = T;
      return
    case 'offset', v = [r.links.offset]';
    case 'qlim'
      v = repmat([-pi pi], numel(r.links), 1);
      for k = 1:numel(r.links)
        if ~isempty(r.links(k).qlim), v(k, :) = r.links(k).qlim(:)'; end
      end
    case 'mdh', v = any([r.links.mdh]);
    case 'config'
      letters = 'RP';
      v = letters([r.links.sigma] + 1);
    case {'name', 'manuf', 'comment', 'base', 'tool', 'gravity', 'q', 'plotopt', 'ikineType'}, v = r.(name);
    otherwise
      if ~any(exist(name) == [2 5 103])
        error('an arm has no field or method ''%s''; it has fkine, ikine, jacob0, rne and others', name);
      end
      given = {};
      if numel(s) > 1 && strcmp(s(2).type, '()'), given = s(2).subs; s(2) = []; end
      outputs = 1;
      % A script beside the user's may have the name of a function that arms have.
      try, outputs = nargout(name); catch, end
      if outputs == 0, feval(name, r, given{:}); return, end
      if numel(s) > 1
        [varargout{1:max(nargout, 1)}] = subsref(feval(name, r, given{:}), s(2:end));
      else
        [varargout{1:nargout}] = feval(name, r, given{:});
      end
      return
  end
  if numel(s) > 1, v = subsref(v, s(2:end)); end
  varargout{1} = v;
end
