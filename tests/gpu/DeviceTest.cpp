#include <isofront/gpu/Barriers.h>
#include <isofront/gpu/Buffer.h>
#include <isofront/gpu/Commands.h>
#include <isofront/gpu/Device.h>
#include <isofront/gpu/Timestamps.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace isofront::gpu {
namespace {

TEST(Device, isFoundAndDescribed)
{
    const auto devices = availableDevices();
    ASSERT_TRUE(devices) << devices.error().message;
    ASSERT_FALSE(devices->empty());
    EXPECT_TRUE(std::any_of(devices->begin(), devices->end(), [](const DeviceDescription& d) {
        return d.isUsable() && !d.name.empty() && d.localBytes > 0;
    }));
    const auto device = Device::create();
    ASSERT_TRUE(device) << device.error().message;
    EXPECT_TRUE((*device)->description().isUsable());
}

TEST(Device, isRefusedWhereNoneMatches)
{
    const auto device = Device::create({.device = "voodoo2"});
    ASSERT_FALSE(device);
    EXPECT_EQ(device.error().code, core::ErrorCode::noDevice);
    EXPECT_NE(device.error().message.find("voodoo2"), std::string::npos);
    EXPECT_NE(device.error().message.find("mesa-vulkan-drivers"), std::string::npos);
}

TEST(Device, isTakenFromTheEnvironmentUnlessNamed)
{
    ASSERT_EQ(setenv("ISOFRONT_DEVICE", "voodoo3", 1), 0); // NOLINT(concurrency-mt-unsafe)
    const auto fromEnvironment = Device::create();
    const auto named = Device::create({.device = "0"});
    unsetenv("ISOFRONT_DEVICE"); // NOLINT(concurrency-mt-unsafe)
    ASSERT_FALSE(fromEnvironment);
    EXPECT_NE(fromEnvironment.error().message.find("voodoo3"), std::string::npos);
    EXPECT_TRUE(named);
}

class ValidatedDevice : public testing::Test {
protected:
    void SetUp() override
    {
        auto created = Device::create({.validation = true});
        ASSERT_TRUE(created) << created.error().message;
        device = std::move(*created);
    }
    void TearDown() override
    {
        if (!device)
            return;
        for (const std::string& message : device->validationMessages())
            ADD_FAILURE() << message;
    }
    Buffer buffer(VkDeviceSize bytes, MemoryKind kind) const
    {
        auto made = Buffer::create(
            *device,
            bytes,
            VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
            kind);
        EXPECT_TRUE(made);
        return std::move(*made);
    }

    std::unique_ptr<Device> device;
};

TEST_F(ValidatedDevice, copiesThroughItsOwnMemoryAndBack)
{
    const Buffer upload = buffer(4096, MemoryKind::upload);
    const Buffer local = buffer(4096, MemoryKind::device);
    const Buffer back = buffer(4096, MemoryKind::readback);
    EXPECT_TRUE(local.mapped().empty());
    for (std::size_t i = 0; i < 4096; ++i)
        upload.mapped()[i] = static_cast<std::byte>(i * 7);
    auto commands = Commands::create(*device);
    ASSERT_TRUE(commands);
    for (int round = 0; round < 3; ++round) {
        ASSERT_TRUE(commands->begin());
        const VkBufferCopy all{0, 0, 4096};
        // The round before may still read and write both buffers.
        memoryBarrier(commands->get(), use::kTransferRead, use::kTransferWrite);
        memoryBarrier(commands->get(), use::kTransferWrite, use::kTransferWrite);
        vkCmdCopyBuffer(commands->get(), upload.get(), local.get(), 1, &all);
        memoryBarrier(commands->get(), use::kTransferWrite, use::kTransferRead);
        vkCmdCopyBuffer(commands->get(), local.get(), back.get(), 1, &all);
        memoryBarrier(commands->get(), use::kTransferWrite, use::kHostRead);
        const auto ticket = commands->submit();
        ASSERT_TRUE(ticket);
        ASSERT_TRUE(device->wait(*ticket));
        EXPECT_EQ(device->completed(), *ticket);
    }
    EXPECT_EQ(std::memcmp(upload.mapped().data(), back.mapped().data(), 4096), 0);
}

TEST_F(ValidatedDevice, countsTheMemoryItGaveOut)
{
    const std::uint64_t before = device->allocatedBytes();
    {
        Buffer a = buffer(1U << 20U, MemoryKind::device);
        EXPECT_GE(device->allocatedBytes(), before + (1U << 20U));
        auto image =
            Image::create(*device, 64, 32, VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_USAGE_SAMPLED_BIT);
        ASSERT_TRUE(image);
        Buffer moved = std::move(a);
        a = std::move(moved);
    }
    EXPECT_EQ(device->allocatedBytes(), before);
}

TEST_F(ValidatedDevice, tellsOversizedMemoryAsAResourceLimit)
{
    const VkMemoryRequirements enormous{1ULL << 60U, 16, ~0U};
    const auto memory = device->allocate(enormous, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    ASSERT_FALSE(memory);
    EXPECT_EQ(memory.error().code, core::ErrorCode::resourceLimit);
    device->clearValidationMessages(); // the layers object as well
}

TEST_F(ValidatedDevice, measuresTimeThatDoesNotRunBackwards)
{
    auto timestamps = Timestamps::create(*device, 3);
    auto commands = Commands::create(*device);
    ASSERT_TRUE(timestamps && commands);
    EXPECT_TRUE(timestamps->spans().empty());
    const Buffer large = buffer(16U << 20U, MemoryKind::device);
    ASSERT_TRUE(commands->begin());
    timestamps->reset(commands->get());
    timestamps->mark(commands->get());
    vkCmdFillBuffer(commands->get(), large.get(), 0, VK_WHOLE_SIZE, 1);
    timestamps->mark(commands->get());
    timestamps->mark(commands->get());
    timestamps->resolve(commands->get());
    const auto ticket = commands->submit();
    ASSERT_TRUE(ticket);
    ASSERT_TRUE(device->wait(*ticket));
    const std::vector<double> spans = timestamps->spans();
    ASSERT_EQ(spans.size(), 2U);
    EXPECT_GT(spans[0], 0.0);
    EXPECT_LT(spans[0], 10'000.0);
    EXPECT_GE(spans[1], 0.0);
}

TEST_F(ValidatedDevice, hearsOfAMissingBarrier)
{
    const Buffer target = buffer(1024, MemoryKind::device);
    auto commands = Commands::create(*device);
    ASSERT_TRUE(commands);
    ASSERT_TRUE(commands->begin());
    vkCmdFillBuffer(commands->get(), target.get(), 0, VK_WHOLE_SIZE, 1);
    vkCmdFillBuffer(commands->get(), target.get(), 0, VK_WHOLE_SIZE, 2);
    const auto ticket = commands->submit();
    ASSERT_TRUE(ticket);
    ASSERT_TRUE(device->wait(*ticket));
    const std::vector<std::string> messages = device->validationMessages();
    ASSERT_EQ(messages.size(), 1U) << "so silence elsewhere means something";
    EXPECT_NE(messages.front().find("SYNC-HAZARD-WRITE-AFTER-WRITE"), std::string::npos);
    device->clearValidationMessages();
    EXPECT_TRUE(device->validationMessages().empty());
}

} // namespace
} // namespace isofront::gpu
