function [found, rest] = mjsim_words(given, usual)
% MJSIM_WORDS  Pairs of names and values over usual ones; what is in neither is the rest.
  found = usual; rest = {}; k = 1;
  while k <= numel(given)
    if ischar(given{k}) && isfield(usual, given{k}) && k < numel(given)
      found.(given{k}) = given{k + 1}; k = k + 1;
    else
      rest{end + 1} = given{k};
    end
    k = k + 1;
  end
end
