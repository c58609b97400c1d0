function n = gcf()
% GCF  Number of the current figure.
  n = mjsim_record('gcf', {});
end
