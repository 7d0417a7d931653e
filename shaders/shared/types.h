// Lets one header be read by GLSL and by C++.
#ifndef ISOFRONT_SHARED_TYPES_H
#define ISOFRONT_SHARED_TYPES_H

#ifdef __cplusplus
#include <glm/ext/vector_int4.hpp>
#include <glm/ext/vector_uint2.hpp>
#include <glm/ext/vector_uint4.hpp>
#include <glm/vec4.hpp>

#include <cstdint>

namespace isofront::shared {
using uint = std::uint32_t;
using vec4 = glm::vec4;
using ivec4 = glm::ivec4;
using uvec2 = glm::uvec2;
using uvec4 = glm::uvec4;
} // namespace isofront::shared

#define ISOFRONT_SHARED_BEGIN namespace isofront::shared {
#define ISOFRONT_SHARED_END }
#define ISOFRONT_SHARED_FUNCTION inline
#else
#define ISOFRONT_SHARED_BEGIN
#define ISOFRONT_SHARED_END
#define ISOFRONT_SHARED_FUNCTION
#endif

#endif
