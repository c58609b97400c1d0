function varargout = subsref(q, s)
% SUBSREF  Parts and functions of quaternions: q.R, q.T, q.s, q.v, q(2), q.interp(p, r), q.inv.
  if strcmp(s(1).type, '()')
    v = quaternion(q.rows(s(1).subs{1}, :));
  else
    name = s(1).subs; given = {};
    switch name
      case {'R', 'r'}, v = rotmat(q, 'point');
      case {'T', 't'}, v = r2t(rotmat(q, 'point'));
      case 's', v = q.rows(:, 1);
      case 'v', v = q.rows(:, 2:4);
      case 'rows', v = q.rows;
      case 'torpy'
        if numel(s) > 1, given = s(2).subs; s(2) = []; end
        v = fliplr(tr2rpy(rotmat(q, 'point'), given{:}));
      case 'toangvec', [varargout{1:max(nargout, 1)}] = tr2angvec(rotmat(q, 'point')); return
      case 'new', v = quaternion(s(2).subs{:}); s(2) = [];
      case {'Rx', 'Ry', 'Rz', 'rpy', 'eul', 'angvec'}
        f = struct('Rx', @rotx_, 'Ry', @roty_, 'Rz', @rotz_, 'rpy', @rpy_, 'eul', @eul2tr, 'angvec', @angvec2r);
        v = quaternion(f.(name)(s(2).subs{:})); s(2) = [];
      case {'plot', 'disp', 'display'}
        if numel(s) > 1, given = s(2).subs; end
        feval(name, q, given{:});
        return
      otherwise
        if numel(s) > 1 && strcmp(s(2).type, '()'), given = s(2).subs; s(2) = []; end
        v = feval(name, q, given{:});
    end
  end
  if numel(s) > 1, v = subsref(v, s(2:end)); end
  varargout{1} = v;
end
function T = rotx_(varargin), T = trotx(varargin{:}); end
function T = roty_(varargin), T = troty(varargin{:}); end
function T = rotz_(varargin), T = trotz(varargin{:}); end
function T = rpy_(varargin), T = rpy2tr(fliplr(varargin{1}), varargin{2:end}); end
