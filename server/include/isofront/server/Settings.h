#pragma once

#include <isofront/core/Result.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace isofront::server {

/// What the service is told before it starts. Each has a default that suits one machine and the
/// people on it; `settingsTable` names them for files, the environment and the command line.
struct Settings {
    // Where it is found
    std::string host = "127.0.0.1"; ///< address to listen on
    std::uint16_t port = 8080;      ///< 0: any that is free
    /// Names by which browsers may call it, besides those of this machine. Others are refused, so
    /// that no foreign page reaches a local service by a name of its own.
    std::vector<std::string> hostNames;
    std::vector<std::string> origins; ///< of pages elsewhere that may use it (CORS); "*" is any

    // What it keeps and shows
    std::filesystem::path data = "isofront-data"; ///< folder of scenes; made if missing
    std::filesystem::path sources; ///< folder of files that scenes may be made of; none if empty
    std::filesystem::path viewer;  ///< folder of the web client; none if empty

    // Who may do what
    std::filesystem::path tokens; ///< file of bearer tokens; none if empty
    /// What those without a token may do: any of "read", "write", "admin". Where no file of tokens
    /// is given and the address is of this machine only, everything.
    std::vector<std::string> anonymous;

    // Limits
    std::uint64_t headerBytes = 16U << 10U;                ///< of a request
    std::uint64_t bodyBytes = 1U << 20U;                   ///< of a request that isn't an upload
    std::uint64_t uploadBytes = std::uint64_t{4} << 30U;   ///< of one upload
    std::uint64_t storageBytes = std::uint64_t{32} << 30U; ///< of all uploads
    std::uint32_t connections = 256;
    std::uint32_t requests = 64; ///< being answered or waiting for it
    std::uint32_t streams = 64;  ///< clients that see a scene change
    std::uint32_t scenes = 1000;
    std::uint64_t memoryBytes = std::uint64_t{4} << 30U;   ///< of open scenes and their cells
    std::uint64_t streamBytes = std::uint64_t{256} << 20U; ///< of what one client sees
    std::uint32_t streamTriangles = 2'000'000;             ///< that one client sees
    std::uint32_t workers = 0;    ///< threads that answer requests; 0: two for each core
    std::uint32_t streamJobs = 2; ///< cells of one client being extracted at once
    double headerSeconds = 10;    ///< from the first byte of a request to the last of its header
    double idleSeconds = 75;      ///< between requests, and between the bytes of one
    double requestSeconds = 60;   ///< that a request is worked on
    double drainSeconds = 10;     ///< for what is under way, once asked to end

    // What it tells
    std::string logLevel = "info";  ///< "debug", "info", "warning" or "error"
    std::string logFormat = "text"; ///< "text" or "json", a line each
};

/// One setting, as files, the environment and the command line know it.
struct Setting {
    /// Lower case with hyphens: `max-connections` in a file, `--max-connections` as an option,
    /// `ISOFRONT_SERVE_MAX_CONNECTIONS` in the environment.
    std::string_view name;
    std::string_view value; ///< what kind of value: "FILE", "BYTES", "N", ...
    std::string_view help;
    /// Fails with a sentence about the value if it is not acceptable.
    core::Result<void> (*set)(Settings&, const std::string&);
    std::string (*show)(const Settings&);
};

/// All settings, in the order in which people should read of them.
std::span<const Setting> settingsTable();

/// The name of a setting in the environment.
std::string environmentName(std::string_view setting);

/// A value that somebody gave, and where, for messages: "--port", "ISOFRONT_SERVE_PORT",
/// "serve.toml:3".
struct GivenSetting {
    std::string name;
    std::string value;
    std::string where;
};

/// The values of all `ISOFRONT_SERVE_...` variables.
/// @param environment  lines `NAME=value`, as a process has them
std::vector<GivenSetting> settingsOfEnvironment(std::span<const std::string> environment);

/// The settings of a file: lines `name = value`. A value is plain up to the end of the line, in
/// double quotes (with \\ and \" for these two characters), in single ones, or a list of such in
/// brackets, which is the same as one text with commas; # begins a comment. Errors: inputOutput for
/// what can't be read; usage for lines that aren't so, and names that come twice. All name the file
/// and the line.
core::Result<std::vector<GivenSetting>> settingsOfFile(const std::filesystem::path& file);
/// The same of the text of a file.
core::Result<std::vector<GivenSetting>>
parseSettings(std::string_view text, const std::string& file);
/// A value as a file has it, in quotes.
std::string quotedSetting(std::string_view value);

struct SettingsInForce {
    Settings settings;
    /// For each of `settingsTable`, where its value is from; empty for the default.
    std::vector<std::string> origins;
};

/// Puts settings together; the later ones of a name win.
/// Errors: usage for unknown names and values that are not acceptable, naming where they are, and
/// for an address that others can reach while nobody needs a token.
core::Result<SettingsInForce> settingsFrom(std::span<const GivenSetting> given);

/// Whether an address is of this machine only.
bool isLoopback(std::string_view host);

} // namespace isofront::server
