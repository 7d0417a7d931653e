#version 460

// Only what passes the depth test gets here.
layout(early_fragment_tests) in;

layout(set = 0, binding = 6, std430) buffer Visible { uint visible[]; };

layout(location = 0) flat in uint drawn;

void main()
{
    if (visible[drawn] == 0u)
        visible[drawn] = 1u;
}
