function packed = mjsim_pack(value, fields)
% MJSIM_PACK  Return fields of a struct as a column of doubles; the field '' is the value itself.
%
% Each field consists of its kind (0 missing, 1 numbers, 2 a text that describes its type, 3 JSON), the number of
% dimensions, the dimensions, and the entries.
parts = cell(numel(fields), 1);
for k = 1:numel(fields)
    name = fields{k};
    if isempty(name)
        parts{k} = mjsim_part(value, name);
    elseif isstruct(value) && numel(value) == 1 && isfield(value, name)
        parts{k} = mjsim_part(value.(name), name);
    elseif isstruct(value) && numel(value) == 1
        parts{k} = [0; 1; 0];
    else
        parts{k} = mjsim_text(2, ['of ' class(value) ', not of struct']);
    end
end
packed = vertcat(parts{:});
end

function part = mjsim_part(value, name)
if strcmp(name, 'show')
    part = mjsim_text(3, jsonencode(value));
elseif (isnumeric(value) || islogical(value)) && isreal(value)
    part = [1; ndims(value); size(value)'; full(double(value(:)))];
elseif isnumeric(value)
    part = mjsim_text(2, 'complex');
elseif strcmp(name, 'messages') || strcmp(name, 'joints')
    part = mjsim_text(3, jsonencode(value));
else
    part = mjsim_text(2, ['of ' class(value)]);
end
end

function part = mjsim_text(kind, text)
part = [kind; 1; numel(text); double(uint8(text(:)))];
end
