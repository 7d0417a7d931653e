#pragma once

// What the module of Embree's rays and its callers agree upon. It is loaded only when it is
// measured, so that the benchmarks link no ray tracer that nothing else needs.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace isofront::bench::peers {

/// One ray, and what it meets.
struct EmbreeRay {
    std::array<float, 3> start{};
    std::array<float, 3> direction{}; ///< unit length
    float distance = 0;               ///< out: to the first triangle; below 0 for none
};

/// `isofrontEmbreeScene`: triangles with the tree that finds them, at Embree's highest quality, on
/// one thread. Null on failure.
using EmbreeScene =
    void* (*)(const std::vector<float>& positions, const std::vector<std::array<std::uint32_t, 3>>& triangles);
/// `isofrontEmbreeCast`: casts rays one by one on the calling thread.
/// `isofrontEmbreeCastPackets`: the same, sixteen at a time, told that they have much in common.
/// Thread: any number at once.
using EmbreeCast = void (*)(void* scene, std::span<EmbreeRay> rays);
/// `isofrontEmbreeMemory`: that the scene takes beside positions and triangles [bytes].
using EmbreeMemory = std::int64_t (*)(void* scene);
/// `isofrontEmbreeClose`.
using EmbreeClose = void (*)(void* scene);

} // namespace isofront::bench::peers
