#include "Arguments.h"
#include "Console.h"

#include <isofront/server/Server.h>
#include <isofront/server/Settings.h>

#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

namespace isofront::cli {

namespace {

struct ServeArguments {
    std::optional<std::string> config; ///< a file
    bool printConfig = false;
    std::vector<std::string> values; ///< in the order of the table of settings
    std::vector<const CLI::Option*> options;
};

/// Where the build and the installation put the web client; empty if it isn't there.
std::filesystem::path builtViewer()
{
    std::error_code ignored;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", ignored);
    std::filesystem::path folder =
        program.parent_path().parent_path() / "share" / "isofront" / "viewer";
    return std::filesystem::exists(folder / "index.html", ignored) ? folder
                                                                   : std::filesystem::path();
}

/// Of the file, the environment and the command line, in this order: the last one wins.
core::Result<server::SettingsInForce> settingsOf(const ServeArguments& arguments)
{
    std::vector<server::GivenSetting> given;
    if (arguments.config) {
        if (arguments.config->empty())
            return core::failure(core::ErrorCode::usage, "--config: '' is no file of settings");
        auto ofFile = server::settingsOfFile(*arguments.config);
        if (!ofFile)
            return tl::unexpected(ofFile.error());
        given = std::move(*ofFile);
    }
    std::vector<std::string> environment;
    for (char** line = environ; *line != nullptr; ++line)
        environment.emplace_back(*line);
    for (server::GivenSetting& setting : server::settingsOfEnvironment(environment))
        given.push_back(std::move(setting));
    const auto table = server::settingsTable();
    for (std::size_t i = 0; i < table.size(); ++i)
        if (arguments.options[i]->count() > 0)
            given.push_back(
                {std::string(table[i].name),
                 arguments.values[i],
                 "--" + std::string(table[i].name)});
    auto inForce = server::settingsFrom(given);
    const auto isViewerGiven = std::ranges::any_of(
        given, [](const server::GivenSetting& setting) { return setting.name == "viewer"; });
    if (inForce && !isViewerGiven)
        inForce->settings.viewer = builtViewer();
    return inForce;
}

/// A file that would lead to the same settings.
void printConfig(const server::SettingsInForce& inForce)
{
    const auto table = server::settingsTable();
    for (std::size_t i = 0; i < table.size(); ++i)
        std::printf(
            "# %s [%s]%s\n%s = %s\n\n",
            std::string(table[i].help).c_str(),
            std::string(table[i].value).c_str(),
            inForce.origins[i].empty() ? "" : (", from " + inForce.origins[i]).c_str(),
            std::string(table[i].name).c_str(),
            server::quotedSetting(table[i].show(inForce.settings)).c_str());
}

int serve(const ServeArguments& arguments)
{
    const auto inForce = settingsOf(arguments);
    if (!inForce)
        return report(inForce.error());
    if (arguments.printConfig) {
        printConfig(*inForce);
        return 0;
    }
    // before there are threads that signals could go to
    const std::stop_token stop = interruptions();
    const auto server = server::Server::start(inForce->settings);
    if (!server)
        return report(server.error());
    std::fprintf(
        stderr, "isofront serves %s (interrupt it to end)\n", (*server)->address().c_str());

    std::mutex mutex;
    std::condition_variable_any changed;
    std::unique_lock lock(mutex);
    changed.wait(lock, stop, [] { return false; });
    return (*server)->drain()
               ? 0
               : report(
                     {core::ErrorCode::interrupted,
                      "not all that was under way came to its end within the drain-timeout"});
}

} // namespace

Action addServe(CLI::App& app)
{
    CLI::App* command =
        app.add_subcommand("serve", "keep scenes and describe them to programs, over HTTP");
    auto arguments = std::make_shared<ServeArguments>();
    command->add_option("--config", arguments->config, "file of settings, 'name = value' a line");
    command->add_flag(
        "--print-config", arguments->printConfig, "print the settings in force, as such a file");
    const auto table = server::settingsTable();
    const server::Settings defaults;
    arguments->values.resize(table.size());
    for (std::size_t i = 0; i < table.size(); ++i) {
        const std::string shown = table[i].show(defaults);
        CLI::Option* option = command->add_option(
            "--" + std::string(table[i].name),
            arguments->values[i],
            std::string(table[i].help) + (shown.empty() ? "" : " [" + shown + "]"));
        option->type_name(std::string(table[i].value));
        arguments->options.push_back(option);
    }
    command->footer(
        "Each option is a setting: a flag here, 'name = value' in the file, or a variable of the\n"
        "environment such as ISOFRONT_SERVE_PORT. Flags win over the environment, and that over\n"
        "the file.\n\n"
        "Examples:\n"
        "  isofront serve\n"
        "  isofront serve --sources ~/scans --port 9000\n"
        "  isofront serve --host 0.0.0.0 --tokens tokens.txt --host-names scans.example.org\n"
        "  isofront serve --print-config >serve.toml");
    return [arguments] { return serve(*arguments); };
}

} // namespace isofront::cli
