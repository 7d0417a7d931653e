#include <isofront/server/Settings.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

namespace isofront::server {
namespace {

core::Result<void> wrong(const std::string& value, const std::string& expected)
{
    return core::failure(core::ErrorCode::usage, "'" + value + "' is not " + expected);
}

template <typename T>
std::optional<T> numberOf(std::string_view text)
{
    T number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size())
        return std::nullopt;
    return number;
}

/// "512MiB", "4 GiB", "65536".
std::optional<std::uint64_t> bytesOf(std::string_view text)
{
    const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
    const auto number = numberOf<std::uint64_t>(text.substr(0, digits));
    std::string_view unit = text.substr(digits);
    while (unit.starts_with(' '))
        unit.remove_prefix(1);
    constexpr std::array<std::string_view, 4> units{"", "KiB", "MiB", "GiB"};
    const auto found = std::ranges::find(units, unit == "B" ? std::string_view() : unit);
    if (!number || found == units.end())
        return std::nullopt;
    const auto shift = static_cast<unsigned>(10 * (found - units.begin()));
    if (*number > (std::numeric_limits<std::uint64_t>::max() >> shift))
        return std::nullopt;
    return *number << shift;
}

std::string bytesShown(std::uint64_t bytes)
{
    constexpr std::array<const char*, 4> units{"", "KiB", "MiB", "GiB"};
    std::size_t unit = 0;
    while (unit + 1 < units.size() && bytes != 0 && bytes % 1024 == 0) {
        bytes /= 1024;
        ++unit;
    }
    return std::to_string(bytes) + units[unit];
}

std::vector<std::string> listOf(const std::string& text)
{
    std::vector<std::string> list;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        std::size_t first = begin;
        std::size_t last = end;
        while (first < last && text[first] == ' ')
            ++first;
        while (last > first && text[last - 1] == ' ')
            --last;
        if (last > first)
            list.push_back(text.substr(first, last - first));
        begin = end + 1;
    }
    return list;
}

std::string listShown(const std::vector<std::string>& list)
{
    std::string text;
    for (const std::string& item : list)
        text += (text.empty() ? "" : ",") + item;
    return text;
}

template <std::filesystem::path Settings::*member>
constexpr Setting path(std::string_view name, std::string_view value, std::string_view help)
{
    return {
        name,
        value,
        help,
        [](Settings& settings, const std::string& text) -> core::Result<void> {
            settings.*member = text;
            return {};
        },
        [](const Settings& settings) { return (settings.*member).string(); }};
}

template <std::vector<std::string> Settings::*member>
constexpr Setting list(std::string_view name, std::string_view value, std::string_view help)
{
    return {
        name,
        value,
        help,
        [](Settings& settings, const std::string& text) -> core::Result<void> {
            settings.*member = listOf(text);
            return {};
        },
        [](const Settings& settings) { return listShown(settings.*member); }};
}

template <
    std::uint64_t Settings::*member,
    std::uint64_t least,
    std::uint64_t most = std::numeric_limits<std::uint64_t>::max()>
constexpr Setting bytes(std::string_view name, std::string_view help)
{
    return {
        name,
        "BYTES",
        help,
        [](Settings& settings, const std::string& text) -> core::Result<void> {
            const auto number = bytesOf(text);
            if (!number || *number < least || *number > most)
                return wrong(
                    text,
                    "a number of bytes from " + bytesShown(least) +
                        (most == std::numeric_limits<std::uint64_t>::max()
                             ? " on, such as 512MiB"
                             : " to " + bytesShown(most)));
            settings.*member = *number;
            return {};
        },
        [](const Settings& settings) { return bytesShown(settings.*member); }};
}

template <auto member, std::uint32_t least, std::uint32_t most>
constexpr Setting count(std::string_view name, std::string_view help)
{
    return {
        name,
        "N",
        help,
        [](Settings& settings, const std::string& text) -> core::Result<void> {
            const auto number = numberOf<std::uint32_t>(text);
            if (!number || *number < least || *number > most)
                return wrong(
                    text,
                    "a whole number from " + std::to_string(least) + " to " + std::to_string(most));
            settings.*member =
                static_cast<std::remove_reference_t<decltype(settings.*member)>>(*number);
            return {};
        },
        [](const Settings& settings) { return std::to_string(settings.*member); }};
}

template <double Settings::*member>
constexpr Setting seconds(std::string_view name, std::string_view help)
{
    return {
        name,
        "SECONDS",
        help,
        [](Settings& settings, const std::string& text) -> core::Result<void> {
            const auto number = numberOf<double>(text);
            if (!number || !(*number >= 0.1) || !(*number <= 86400))
                return wrong(text, "a number of seconds from 0.1 to 86400");
            settings.*member = *number;
            return {};
        },
        [](const Settings& settings) {
            std::array<char, 32> digits{};
            const auto end =
                std::to_chars(digits.data(), digits.data() + digits.size(), settings.*member);
            return std::string(digits.data(), end.ptr);
        }};
}

core::Result<void>
chosen(std::string& setting, const std::string& text, std::span<const std::string_view> choices)
{
    if (std::ranges::find(choices, text) != choices.end()) {
        setting = text;
        return {};
    }
    std::string names;
    for (const std::string_view choice : choices)
        names += (names.empty() ? "" : ", ") + std::string(choice);
    return wrong(text, "one of " + names);
}

constexpr std::array<std::string_view, 4> kLogLevels{"debug", "info", "warning", "error"};
constexpr std::array<std::string_view, 2> kLogFormats{"text", "json"};
constexpr std::array<std::string_view, 3> kScopes{"read", "write", "admin"};
constexpr std::uint32_t kMany = 1'000'000;

// clang-format off
const std::array kTable{
    Setting{
        "host", "ADDRESS", "address to listen on; 0.0.0.0 for all of this machine's",
        [](Settings& settings, const std::string& text) -> core::Result<void> {
            if (text.empty())
                return wrong(text, "an address, such as 127.0.0.1");
            settings.host = text;
            return {};
        },
        [](const Settings& settings) { return settings.host; }},
    count<&Settings::port, 0, 65535>("port", "port to listen on; 0 for any that is free"),
    list<&Settings::hostNames>("host-names", "NAME,...", "further names by which browsers may call the service, as example.org"),
    list<&Settings::origins>("cors-origins", "URL,...", "pages elsewhere that may use the service, as https://example.org; * for any"),
    Setting{
        "data", "DIR", "folder in which scenes are kept; made if missing",
        [](Settings& settings, const std::string& text) -> core::Result<void> {
            if (text.empty())
                return wrong(text, "a folder; . is the one in which the service is started");
            settings.data = text;
            return {};
        },
        [](const Settings& settings) { return settings.data.string(); }},
    path<&Settings::sources>("sources", "DIR", "folder of files that scenes may be made of by name"),
    path<&Settings::viewer>("viewer", "DIR", "folder of the web client; by default the one that was built with the program"),
    path<&Settings::tokens>("tokens", "FILE", "bearer tokens, one a line: scopes, name, token"),
    Setting{
        "anonymous", "SCOPE,...", "what is allowed without a token: read, write, admin",
        [](Settings& settings, const std::string& text) -> core::Result<void> {
            const std::vector<std::string> scopes = listOf(text);
            for (const std::string& scope : scopes)
                if (std::ranges::find(kScopes, scope) == kScopes.end())
                    return wrong(scope, "one of read, write, admin");
            settings.anonymous = scopes;
            return {};
        },
        [](const Settings& settings) { return listShown(settings.anonymous); }},
    bytes<&Settings::headerBytes, 1024, 32768>("max-header", "the longest header of a request"),
    bytes<&Settings::bodyBytes, 1024>("max-body", "the longest body of a request that isn't an upload"),
    bytes<&Settings::uploadBytes, 0>("max-upload", "the largest file that may be uploaded"),
    bytes<&Settings::storageBytes, 0>("max-storage", "how much all uploads may take together"),
    count<&Settings::connections, 1, kMany>("max-connections", "connections at once"),
    count<&Settings::requests, 1, kMany>("max-requests", "requests that are answered or wait at once"),
    count<&Settings::streams, 0, kMany>("max-streams", "clients that see scenes change at once"),
    count<&Settings::scenes, 1, kMany>("max-scenes", "scenes that are kept"),
    bytes<&Settings::memoryBytes, 1U << 26U>("max-memory", "memory for open scenes and their cells"),
    bytes<&Settings::streamBytes, 1U << 20U>("max-stream-memory", "memory for what one client sees"),
    count<&Settings::streamTriangles, 1000, 100'000'000>("max-stream-triangles", "triangles that one client sees"),
    count<&Settings::workers, 0, 1024>("workers", "threads that answer requests; 0 for two a core"),
    count<&Settings::streamJobs, 1, 1024>("stream-jobs", "cells of one client that are extracted at once"),
    seconds<&Settings::headerSeconds>("header-timeout", "for a request's header to come in"),
    seconds<&Settings::idleSeconds>("idle-timeout", "between two requests, or two parts of one"),
    seconds<&Settings::requestSeconds>("request-timeout", "for a request to be worked on, as rays are cast"),
    seconds<&Settings::drainSeconds>("drain-timeout", "for what is under way when the service ends"),
    Setting{
        "log-level", "LEVEL", "debug, info, warning or error",
        [](Settings& settings, const std::string& text) { return chosen(settings.logLevel, text, kLogLevels); },
        [](const Settings& settings) { return settings.logLevel; }},
    Setting{
        "log-format", "FORMAT", "text or json, one line an event, on standard error",
        [](Settings& settings, const std::string& text) { return chosen(settings.logFormat, text, kLogFormats); },
        [](const Settings& settings) { return settings.logFormat; }},
};
// clang-format on

constexpr std::string_view kEnvironmentPrefix = "ISOFRONT_SERVE_";

} // namespace

std::span<const Setting> settingsTable()
{
    return kTable;
}

std::string environmentName(std::string_view setting)
{
    std::string name(kEnvironmentPrefix);
    for (const char c : setting)
        name += c == '-' ? '_' : static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
    return name;
}

std::vector<GivenSetting> settingsOfEnvironment(std::span<const std::string> environment)
{
    std::vector<GivenSetting> given;
    for (const std::string& line : environment) {
        const std::size_t equals = line.find('=');
        if (!line.starts_with(kEnvironmentPrefix) || equals == std::string::npos)
            continue;
        const std::string variable = line.substr(0, equals);
        std::string name;
        for (const char c : variable.substr(kEnvironmentPrefix.size()))
            name += c == '_' ? '-' : static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
        given.push_back({name, line.substr(equals + 1), variable});
    }
    return given;
}

bool isLoopback(std::string_view host)
{
    if (host == "localhost" || host == "::1")
        return true;
    // 127.0.0.0/8, written as four numbers: "127.evil.example" is a name
    return host.starts_with("127.") &&
           host.find_first_not_of("0123456789.") == std::string_view::npos &&
           std::ranges::count(host, '.') == 3;
}

core::Result<SettingsInForce> settingsFrom(std::span<const GivenSetting> given)
{
    SettingsInForce inForce;
    inForce.origins.resize(kTable.size());
    for (const GivenSetting& setting : given) {
        const auto known =
            std::ranges::find(kTable, std::string_view(setting.name), &Setting::name);
        if (known == kTable.end())
            return core::failure(
                core::ErrorCode::usage,
                setting.where + ": there is no setting '" + setting.name +
                    "' (see 'isofront serve --print-config')");
        if (const auto set = known->set(inForce.settings, setting.value); !set)
            return tl::unexpected(set.error().within(setting.where + ": " + setting.name));
        inForce.origins[static_cast<std::size_t>(known - kTable.begin())] = setting.where;
    }
    Settings& settings = inForce.settings;
    const bool anonymousGiven =
        std::ranges::any_of(given, [](const GivenSetting& one) { return one.name == "anonymous"; });
    if (!anonymousGiven && settings.tokens.empty()) {
        if (!isLoopback(settings.host))
            return core::failure(
                core::ErrorCode::usage,
                "host: others can reach " + settings.host +
                    ": give tokens in a file (--tokens), or say what all may do without one "
                    "(--anonymous read)");
        settings.anonymous = {"read", "write", "admin"};
    }
    return inForce;
}

} // namespace isofront::server
