#include <isofront/gpu/DeviceChoice.h>

#include <gtest/gtest.h>

namespace isofront::gpu {
namespace {

DeviceDescription described(const char* name, DeviceKind kind)
{
    DeviceDescription device;
    device.name = name;
    device.kind = kind;
    return device;
}

std::vector<DeviceDescription> machine()
{
    std::vector<DeviceDescription> devices{
        described("llvmpipe (LLVM 15)", DeviceKind::cpu),
        described("Intel UHD", DeviceKind::integrated),
        described("NVIDIA RTX", DeviceKind::discrete),
        described("NVIDIA Old", DeviceKind::discrete)};
    devices[3].obstacles = {"only Vulkan 1.1.0, not 1.3"};
    return devices;
}

TEST(DeviceChoice, prefersDiscreteThenIntegratedThenCpu)
{
    std::vector<DeviceDescription> devices = machine();
    EXPECT_EQ(chooseDevice(devices, ""), 2U);
    devices[2].obstacles = {"broken"};
    EXPECT_EQ(chooseDevice(devices, ""), 1U);
    devices[1].obstacles = {"broken"};
    EXPECT_EQ(chooseDevice(devices, ""), 0U);
}

TEST(DeviceChoice, takesIndexKindOrPartOfTheNameInAnyCase)
{
    const std::vector<DeviceDescription> devices = machine();
    EXPECT_EQ(chooseDevice(devices, "1"), 1U);
    EXPECT_EQ(chooseDevice(devices, "cpu"), 0U);
    EXPECT_EQ(chooseDevice(devices, "CPU"), 0U);
    EXPECT_EQ(chooseDevice(devices, "gpu"), 2U);
    EXPECT_EQ(chooseDevice(devices, "LLVMpipe"), 0U);
    EXPECT_EQ(chooseDevice(devices, "nvidia"), 2U) << "the usable one of the two";
}

TEST(DeviceChoice, explainsARefusalWithReasonsAndRemedy)
{
    const std::vector<DeviceDescription> devices = machine();
    for (const char* wanted : {"voodoo", "7", "3", "-1", "1x"}) {
        const core::Result<std::size_t> choice = chooseDevice(devices, wanted);
        ASSERT_FALSE(choice) << wanted;
        EXPECT_EQ(choice.error().code, core::ErrorCode::noDevice);
        EXPECT_NE(choice.error().message.find("only Vulkan 1.1.0"), std::string::npos);
        EXPECT_NE(choice.error().message.find("Intel UHD"), std::string::npos);
        EXPECT_NE(choice.error().message.find("mesa-vulkan-drivers"), std::string::npos);
        EXPECT_NE(choice.error().message.find(wanted), std::string::npos);
    }
    EXPECT_FALSE(chooseDevice({}, ""));
}

} // namespace
} // namespace isofront::gpu
