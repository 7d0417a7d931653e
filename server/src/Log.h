#pragma once

#include <isofront/server/Settings.h>

#include <nlohmann/json.hpp>

#include <memory>
#include <string_view>

namespace spdlog {
class logger;
}

namespace isofront::server {

enum class LogLevel { debug, info, warning, error };

/// What happens, a line an event on standard error: a name, and fields that programs can read.
///
/// Thread: any.
class Log {
public:
    explicit Log(const Settings& settings);
    Log(const Log&) = delete;
    Log& operator=(const Log&) = delete;
    ~Log();

    /// @param fields  an object; its values are numbers, texts and booleans
    void write(
        LogLevel level,
        std::string_view event,
        const nlohmann::ordered_json& fields = nlohmann::ordered_json::object());
    [[nodiscard]] bool writes(LogLevel level) const;

private:
    std::shared_ptr<spdlog::logger> _logger;
    bool _isJson;
};

} // namespace isofront::server
