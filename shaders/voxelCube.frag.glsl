#version 460

// Only the name: what it looks like is found out once a pixel.
layout(early_fragment_tests) in;

layout(location = 0) flat in uint name;
layout(location = 0) out uint shown;

void main()
{
    shown = name;
}
