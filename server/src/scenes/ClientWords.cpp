#include "ClientWords.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace isofront::server {

std::string inClientWords(std::string message, const std::string& folder)
{
    if (!folder.empty())
        for (std::size_t at = message.find(folder); at != std::string::npos;
             at = message.find(folder, at))
            message.erase(at, folder.size());

    constexpr std::array<std::string_view, 10> kOptions{
        "grid",
        "series",
        "raw",
        "detail",
        "voxel-size",
        "pixel-size",
        "height-scale",
        "no-data",
        "mesh-resolution",
        "mesh-reach"};
    constexpr std::string_view kOtherProgram = "gdcmconv ";
    std::string text;
    for (std::size_t at = 0; at < message.size();) {
        const std::size_t dashes = std::min(message.find("--", at), message.size());
        text.append(message, at, dashes - at);
        const std::size_t begin = std::min(dashes + 2, message.size());
        const std::size_t end = std::min(
            message.find_first_not_of("abcdefghijklmnopqrstuvwxyz-", begin), message.size());
        std::string name = message.substr(begin, end - begin);
        if (name == "memory-limit") {
            text += "the service's max-memory";
        } else if (
            std::ranges::find(kOptions, name) != kOptions.end() && !text.ends_with(kOtherProgram)) {
            std::ranges::replace(name, '-', '_');
            text += "option " + name;
        } else {
            text.append(message, dashes, end - dashes);
        }
        at = end;
    }
    return text;
}

} // namespace isofront::server
