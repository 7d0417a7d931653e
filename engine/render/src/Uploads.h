#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/Barriers.h>
#include <isofront/gpu/Buffer.h>
#include <isofront/gpu/Commands.h>

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace isofront::render {

/// One batch of copies into a buffer: open, fill, submit.
class UploadBatch {
public:
    /// Where to put bytes that go to `offset` of the target [bytes]. At most as many in all as the
    /// batch was opened for.
    std::span<std::byte> place(VkDeviceSize offset, std::size_t bytes);
    /// Copies inside the target after everything placed so far is there; the two don't overlap.
    void move(VkDeviceSize from, VkDeviceSize to, VkDeviceSize bytes);

private:
    friend class Uploads;
    std::span<std::byte> _staging; ///< empty: the target itself is mapped
    std::span<std::byte> _target;
    std::size_t _staged = 0;
    std::vector<VkBufferCopy> _copies, _moves;
};

/// Brings bytes into a buffer on the GPU: directly where it is mapped, otherwise through staging
/// buffers, which are used again once the GPU has read them.
class Uploads {
public:
    Uploads() = default;
    explicit Uploads(gpu::Device& device) : _device(&device) {}

    /// @param bytes  how much will be placed at most
    core::Result<UploadBatch> open(const gpu::Buffer& target, std::size_t bytes);
    /// Hands the batch to the GPU, if there is anything left to do. What is submitted later and
    /// reads in this way sees it.
    core::Result<void> submit(
        const gpu::Buffer& target,
        const UploadBatch& batch,
        const gpu::Use& reader = gpu::use::kVertexRead);

private:
    struct Staging {
        gpu::Buffer buffer;
        gpu::Device::Ticket ticket = 0;
    };
    core::Result<gpu::Commands*> idleCommands();

    gpu::Device* _device = nullptr;
    std::vector<Staging> _staging;
    std::size_t _open = 0; ///< the staging buffer of the batch that is open
    std::vector<std::unique_ptr<gpu::Commands>> _commands;
};

} // namespace isofront::render
