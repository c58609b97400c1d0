function text = trchain(r)
% TRCHAIN  The elementary transformations of an arm's links in words.
  text = ''; k = 0;
  for l = mjsim_plain(r).links
    k = k + 1; turn = number('Rz', l.theta * 180 / pi); move = number('Tz', l.d);
    if l.sigma, move = sprintf('Tz(q%d)', k); else, turn = sprintf('Rz(q%d)', k); end
    across = [number('Tx', l.a), number('Rx', l.alpha * 180 / pi)];
    if l.mdh, across = [number('Rx', l.alpha * 180 / pi), number('Tx', l.a)]; text = [text, across, turn, move];
    else, text = [text, turn, move, across]; end
  end
end
function text = number(kind, value)
  text = '';
  if abs(value) > 1e-12, text = sprintf('%s(%g)', kind, value); end
end
