function mjsim_serve(name, file, requests, answers)
% MJSIM_SERVE  Call the function NAME, in FILE, for each request of mjsim, until there are no more.
%
% A request is six numbers (kind, layout, length of its code, number of ends, of numbers, of bytes), then the code of
% the layout if it is new, then ends and numbers as doubles, then bytes. An answer is a count, and that many doubles:
% the first is 0 for a result, 1 for an error.
in = fopen(requests, 'r');
out = fopen(answers, 'w');
layouts = {};
robot = [];
state = [];
fields = {};
call = [];
while true
    head = fread(in, 6, 'double');
    if numel(head) < 6
        break
    end
    if head(3) > 0
        code = fread(in, [1, head(3)], 'uint8=>char');
    end
    ends = fread(in, head(4), 'double');
    numbers = fread(in, head(5), 'double');
    bytes = fread(in, head(6), 'uint8=>uint8');
    try
        if head(3) > 0
            layouts{head(2)} = str2func(['@(d,e,b)' code]);
        end
        build = layouts{head(2)};
        given = build(numbers, ends, bytes);
        if head(1) == 1
            fields = given.fields;
            robot = given.robot;
            call = mjsim_find(name, file, given.seeds);
            answer = 0;
        else
            given = struct2cell(given);
            [value, state] = call(given{:}, robot, state);
            answer = [0; mjsim_pack(value, fields)];
        end
    catch err
        answer = [1; mjsim_fault(err)];
    end
    % The whole answer is ready before the first byte is written.
    fwrite(out, [numel(answer); answer], 'double');
    fflush(out);
end
end

function call = mjsim_find(name, file, seeds)
% Return the function after reading its file, with newly seeded random generators.
found = which(name);
if ~strcmp(found, file)
    error('mjsim:name', 'the name %s stands for %s; rename one of them', name, found);
end
nargin(name);
call = str2func(name);
rand('twister', seeds(:, 1));
randn('twister', seeds(:, 2));
rande('twister', seeds(:, 3));
randg('twister', seeds(:, 4));
randp('twister', seeds(:, 5));
end

function text = mjsim_fault(err)
% Return message and stack as bytes, one line per frame, innermost first.
text = [err.message char(10) char(1)];
for k = 1:numel(err.stack)
    frame = err.stack(k);
    text = [text sprintf('\n%d\t%s\t%s', frame.line, frame.name, frame.file)];
end
text = double(uint8(text(:)));
end
