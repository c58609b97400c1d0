function varargout = mjsim_recorded(name, given, count)
% MJSIM_RECORDED  Keeps a call, and returns what MATLAB would: a handle, limits, or levels before the handle.
  own = given;
  if ~isempty(own) && isnumeric(own{1}) && isscalar(own{1}) && isaxes(own{1}), own(1) = []; end
  if count > 0 && isempty(own) && any(strcmp(name, {'axis', 'xlim', 'ylim', 'zlim'}))
    limits = mjsim_limits(given{:});
    switch name
      case 'axis', varargout{1} = limits;
      case 'xlim', varargout{1} = limits(1:2);
      case 'ylim', varargout{1} = limits(3:4);
      case 'zlim', varargout{1} = [limits(5:end), zeros(1, 6 - numel(limits))];
    end
    return
  elseif count > 0 && isempty(own) && strcmp(name, 'colormap')
    varargout{1} = viridis(64);
    return
  elseif count > 1 && strcmp(name, 'view')
    [varargout{1:2}] = deal(-37.5, 30);
    return
  elseif strcmp(name, 'delete') && ~isempty(given) && ischar(given{1})
    cellfun(@(f) unlink(f), glob(given));
    varargout{1} = [];
    return
  end
  if strcmp(name, 'plot') && numel(given) > 1 && isstruct(given{1}) && isfield(given{1}, 'before')
    % robot.arms.NAME of a module: the lines from joint to joint.
    chain = mjsim_chain(given{1}); lines_ = {};
    for q = given{2}'
      T = mjsim_frames(chain, q);
      P = [chain.base(1:3, 4), reshape(T(1:3, 4, :), 3, []), (T(:, :, chain.carrier) * chain.tool)(1:3, 4)];
      lines_ = [lines_, {P(1, :), P(2, :), P(3, :), 'o-'}];
    end
    name = 'plot3'; given = lines_;
  end
  id = mjsim_record(name, given);
  varargout = repmat({id}, 1, max(count, 1));
  if count > 1 && (strncmp(name, 'contour', 7) || strcmp(name, 'legend'))
    varargout{1} = [];
    varargout{2} = id;
    if strcmp(name, 'legend'), varargout{1} = id; end
  end
end
