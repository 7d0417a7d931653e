#include "Uploads.h"

#include <isofront/core/Assert.h>
#include <isofront/gpu/Barriers.h>

#include <algorithm>
#include <bit>

namespace isofront::render {

namespace {

constexpr std::size_t kLeastStaging = std::size_t{4} << 20U;

} // namespace

std::span<std::byte> UploadBatch::place(VkDeviceSize offset, std::size_t bytes)
{
    if (!_target.empty())
        return _target.subspan(offset, bytes);
    ISOFRONT_ASSERT(_staged + bytes <= _staging.size(), "more bytes than the batch was opened for");
    const std::span<std::byte> place = _staging.subspan(_staged, bytes);
    _copies.push_back({_staged, offset, bytes});
    _staged += bytes;
    return place;
}

void UploadBatch::move(VkDeviceSize from, VkDeviceSize to, VkDeviceSize bytes)
{
    _moves.push_back({from, to, bytes});
}

core::Result<UploadBatch> Uploads::open(const gpu::Buffer& target, std::size_t bytes)
{
    UploadBatch batch;
    batch._target = target.mapped();
    if (!batch._target.empty() || bytes == 0)
        return batch;
    const core::Result<gpu::Device::Ticket> completed = _device->completed();
    if (!completed)
        return tl::unexpected(completed.error());
    const auto fits = [&](const Staging& staging) {
        return staging.ticket <= *completed && staging.buffer.bytes() >= bytes;
    };
    const auto found = std::find_if(_staging.begin(), _staging.end(), fits);
    _open = static_cast<std::size_t>(found - _staging.begin());
    if (found == _staging.end()) {
        // Idle ones that are too small make room for one that fits.
        std::erase_if(_staging, [&](const Staging& s) { return s.ticket <= *completed; });
        core::Result<gpu::Buffer> buffer = gpu::Buffer::create(
            *_device,
            std::bit_ceil(std::max(bytes, kLeastStaging)),
            VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
            gpu::MemoryKind::upload);
        if (!buffer)
            return tl::unexpected(buffer.error());
        _open = _staging.size();
        _staging.push_back({std::move(*buffer), 0});
    }
    batch._staging = _staging[_open].buffer.mapped();
    return batch;
}

core::Result<gpu::Commands*> Uploads::idleCommands()
{
    const core::Result<gpu::Device::Ticket> completed = _device->completed();
    if (!completed)
        return tl::unexpected(completed.error());
    for (const std::unique_ptr<gpu::Commands>& commands : _commands) {
        if (commands->ticket() <= *completed)
            return commands.get();
    }
    core::Result<gpu::Commands> created = gpu::Commands::create(*_device);
    if (!created)
        return tl::unexpected(created.error());
    _commands.push_back(std::make_unique<gpu::Commands>(std::move(*created)));
    return _commands.back().get();
}

core::Result<void>
Uploads::submit(const gpu::Buffer& target, const UploadBatch& batch, const gpu::Use& reader)
{
    if (batch._copies.empty() && batch._moves.empty())
        return {};
    const core::Result<gpu::Commands*> commands = idleCommands();
    if (!commands)
        return tl::unexpected(commands.error());
    if (core::Result<void> begun = (*commands)->begin(); !begun)
        return begun;
    const VkCommandBuffer buffer = (*commands)->get();
    const auto count = [](const std::vector<VkBufferCopy>& list) {
        return static_cast<std::uint32_t>(list.size());
    };
    constexpr gpu::Use kTransfer{
        gpu::use::kTransferRead.stages,
        gpu::use::kTransferRead.access | gpu::use::kTransferWrite.access};
    if (!batch._copies.empty())
        vkCmdCopyBuffer(
            buffer,
            _staging[_open].buffer.get(),
            target.get(),
            count(batch._copies),
            batch._copies.data());
    if (!batch._moves.empty()) {
        gpu::memoryBarrier(buffer, gpu::use::kTransferWrite, kTransfer);
        vkCmdCopyBuffer(
            buffer, target.get(), target.get(), count(batch._moves), batch._moves.data());
    }
    gpu::memoryBarrier(buffer, gpu::use::kTransferWrite, reader);
    const core::Result<gpu::Device::Ticket> ticket = (*commands)->submit();
    if (!ticket)
        return tl::unexpected(ticket.error());
    if (!batch._copies.empty())
        _staging[_open].ticket = *ticket;
    return {};
}

} // namespace isofront::render
