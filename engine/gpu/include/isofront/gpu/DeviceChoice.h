#pragma once

#include <isofront/core/Result.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace isofront::gpu {

enum class DeviceKind { discrete, integrated, virtualised, cpu, other };

/// A Vulkan device of this machine, usable or not.
struct DeviceDescription {
    std::string name;
    std::string driver; ///< name and version of the driver
    DeviceKind kind = DeviceKind::other;
    std::string apiVersion;             ///< such as "1.3.230"
    std::uint64_t localBytes = 0;       ///< of the largest heap of device-local memory
    std::vector<std::string> obstacles; ///< why it can't be used; empty if it can

    [[nodiscard]] bool isUsable() const { return obstacles.empty(); }
};

/// One word for a person: "discrete", "integrated", "virtual", "cpu" or "other".
const char* nameOf(DeviceKind kind);

/// All Vulkan devices of this machine, usable or not, in the loader's order. The list may be empty;
/// the call fails (noDevice) only if there is no Vulkan at all.
core::Result<std::vector<DeviceDescription>> availableDevices();

/// Which device to take: an index into the list.
///
/// @param wanted  empty: the best usable one, where discrete beats integrated beats virtual beats
///                cpu; a number: that index; "cpu": a software device; "gpu": anything but that;
///                otherwise a part of the name, in upper or lower case
/// @return noDevice with the reasons of every refused device and the remedy, if none fits
core::Result<std::size_t>
chooseDevice(std::span<const DeviceDescription> devices, const std::string& wanted);

} // namespace isofront::gpu
