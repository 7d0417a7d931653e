#include "isofront/gpu/DeviceChoice.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <optional>

namespace isofront::gpu {

namespace {

std::string lowered(std::string text)
{
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char letter) {
        return static_cast<char>(std::tolower(letter));
    });
    return text;
}

std::optional<std::size_t> asIndex(const std::string& text)
{
    std::size_t index = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, index);
    return error == std::errc{} && stop == end ? std::optional(index) : std::nullopt;
}

int rankOf(DeviceKind kind)
{
    constexpr std::array kOrder{
        DeviceKind::discrete,
        DeviceKind::integrated,
        DeviceKind::virtualised,
        DeviceKind::cpu,
        DeviceKind::other};
    return static_cast<int>(std::find(kOrder.begin(), kOrder.end(), kind) - kOrder.begin());
}

bool matches(const DeviceDescription& device, std::size_t index, const std::string& wanted)
{
    if (wanted.empty())
        return true;
    if (const std::optional<std::size_t> number = asIndex(wanted))
        return *number == index;
    if (wanted == "cpu")
        return device.kind == DeviceKind::cpu;
    if (wanted == "gpu")
        return device.kind != DeviceKind::cpu;
    return lowered(device.name).find(wanted) != std::string::npos;
}

std::string listed(std::span<const DeviceDescription> devices)
{
    if (devices.empty())
        return "this machine has none";
    std::string text;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        text += (i == 0 ? "" : ", ") + std::to_string(i) + ": " + devices[i].name + " (" +
                nameOf(devices[i].kind);
        for (const std::string& obstacle : devices[i].obstacles)
            text += ", " + obstacle;
        text += ")";
    }
    return text;
}

} // namespace

const char* nameOf(DeviceKind kind)
{
    switch (kind) {
    case DeviceKind::discrete:
        return "discrete";
    case DeviceKind::integrated:
        return "integrated";
    case DeviceKind::virtualised:
        return "virtual";
    case DeviceKind::cpu:
        return "cpu";
    default:
        return "other";
    }
}

core::Result<std::size_t>
chooseDevice(std::span<const DeviceDescription> devices, const std::string& wanted)
{
    const std::string pattern = lowered(wanted);
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        if (!devices[i].isUsable() || !matches(devices[i], i, pattern))
            continue;
        if (!best || rankOf(devices[i].kind) < rankOf(devices[*best].kind))
            best = i;
    }
    if (best)
        return *best;
    const std::string which = wanted.empty() ? "" : " that matches \"" + wanted + "\"";
    return core::failure(
        core::ErrorCode::noDevice,
        "no usable Vulkan device" + which + " (" + listed(devices) +
            "); choose one with --device or ISOFRONT_DEVICE, or install mesa-vulkan-drivers for a "
            "software "
            "device");
}

} // namespace isofront::gpu
