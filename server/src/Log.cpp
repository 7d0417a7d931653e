#include "Log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace isofront::server {
namespace {

using Json = nlohmann::ordered_json;

spdlog::level::level_enum levelOf(LogLevel level)
{
    switch (level) {
    case LogLevel::debug:
        return spdlog::level::debug;
    case LogLevel::info:
        return spdlog::level::info;
    case LogLevel::warning:
        return spdlog::level::warn;
    case LogLevel::error:
        return spdlog::level::err;
    }
    return spdlog::level::info;
}

std::string dumped(const Json& json)
{
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// `name=value`, with quotes where a value has more than a word.
std::string textOf(std::string_view event, const Json& fields)
{
    std::string line(event);
    for (const auto& [name, value] : fields.items()) {
        const std::string quoted = dumped(value);
        const bool isWord = value.is_string() && !value.get_ref<const std::string&>().empty() &&
                            quoted.find_first_of(" \\=") == std::string::npos;
        line += ' ';
        line += name;
        line += '=';
        line += isWord ? quoted.substr(1, quoted.size() - 2) : quoted;
    }
    return line;
}

} // namespace

Log::Log(const Settings& settings)
    : _logger(std::make_shared<spdlog::logger>(
          "isofront", std::make_shared<spdlog::sinks::stderr_sink_mt>())),
      _isJson(settings.logFormat == "json")
{
    _logger->set_level(spdlog::level::from_str(settings.logLevel));
    _logger->set_pattern(
        _isJson ? R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l",%v})"
                : "%Y-%m-%dT%H:%M:%S.%eZ %l %v",
        spdlog::pattern_time_type::utc);
    _logger->flush_on(spdlog::level::debug);
}

Log::~Log() = default;

bool Log::writes(LogLevel level) const
{
    return _logger->should_log(levelOf(level));
}

void Log::write(LogLevel level, std::string_view event, const Json& fields)
{
    if (!writes(level))
        return;
    std::string line;
    if (_isJson) {
        Json all;
        all["event"] = event;
        all.update(fields);
        line = dumped(all);
        line = line.substr(1, line.size() - 2);
    } else {
        line = textOf(event, fields);
    }
    _logger->log(levelOf(level), spdlog::string_view_t(line.data(), line.size()));
}

} // namespace isofront::server
