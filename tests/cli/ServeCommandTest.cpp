#include "CommandFixture.h"
#include "server/HttpClient.h"
#include "server/StreamViewer.h"

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <thread>

namespace isofront::cli {
namespace {

class Serve : public Command {
protected:
    struct Service {
        pid_t process = 0;
        std::uint16_t port = 0; ///< 0: it didn't come up
    };

    Service start() const
    {
        Service service{fork()};
        if (service.process == 0) {
            if (chdir(folder.c_str()) != 0 || std::freopen("errors", "w", stderr) == nullptr)
                _exit(99);
            execl(ISOFRONT_BINARY, "isofront", "serve", "--port", "0", static_cast<char*>(nullptr));
            _exit(99);
        }
        std::string errors;
        std::size_t at = 0;
        const std::string before = "http://127.0.0.1:";
        while ((at = errors.find(before)) == std::string::npos ||
               errors.find('/', at + before.size()) == std::string::npos) {
            EXPECT_EQ(waitpid(service.process, nullptr, WNOHANG), 0) << errors;
            if (HasFailure())
                return service;
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            errors = contentsOf(folder / "errors");
        }
        service.port = static_cast<std::uint16_t>(std::stoi(errors.substr(at + before.size())));
        return service;
    }
    static void end(const Service& service)
    {
        kill(service.process, SIGKILL);
        waitpid(service.process, nullptr, 0);
    }
};

TEST_F(Serve, takesSettingsFromFileEnvironmentAndOptions)
{
    write(
        "serve.toml",
        "port = 1000\nmax-body = \"2MiB\"\ncors-origins = [\"https://a.example\", "
        "\"https://b.example\"]\n");
    const std::string variables = "ISOFRONT_SERVE_PORT=2000 ISOFRONT_SERVE_MAX_STREAMS=5";
    const auto shown = [&](const std::string& arguments, const std::string& environment) {
        const Outcome outcome = run("serve --print-config " + arguments, environment);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.errors;
        return outcome.output;
    };
    const auto has = [](const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    };
    EXPECT_TRUE(has(shown("", ""), "\nport = \"8080\"\n"));
    const std::string ofFile = shown("--config serve.toml", "");
    EXPECT_TRUE(has(ofFile, "from serve.toml:1\nport = \"1000\"\n")) << ofFile;
    EXPECT_TRUE(has(ofFile, "max-body = \"2MiB\""));
    EXPECT_TRUE(has(ofFile, "cors-origins = \"https://a.example,https://b.example\"")) << ofFile;
    const std::string ofBoth = shown("--config serve.toml", variables);
    EXPECT_TRUE(has(ofBoth, "from ISOFRONT_SERVE_PORT\nport = \"2000\"\n")) << ofBoth;
    EXPECT_TRUE(has(ofBoth, "max-streams = \"5\""));
    const std::string ofAll = shown("--config serve.toml --port 3000", variables);
    EXPECT_TRUE(has(ofAll, "from --port\nport = \"3000\"\n")) << ofAll;
    // what is printed is such a file
    write("again.toml", ofAll);
    const std::string again = shown("--config again.toml", "");
    EXPECT_TRUE(has(again, "\nport = \"3000\"\n")) << again;
    EXPECT_TRUE(has(again, "from again.toml:")) << again;
}

TEST_F(Serve, refusesWhatMakesNoSense)
{
    const auto refuses = [&](const std::string& arguments,
                             int code,
                             const std::string& name,
                             const std::string& environment = "") {
        const Outcome outcome = run("serve " + arguments, environment);
        EXPECT_EQ(outcome.exitCode, code) << arguments << "\n" << outcome.errors;
        EXPECT_EQ(std::ranges::count(outcome.errors, '\n'), 1) << outcome.errors;
        EXPECT_NE(outcome.errors.find(name), std::string::npos) << outcome.errors;
    };
    write("unknown.toml", "prot = 80\n");
    write("section.toml", "[server]\nport = 80\n");
    write("value.toml", "# of the lab\n\nport = 70000\n");
    write("file", "");
    refuses("--port 70000", 2, "--port");
    refuses("--config none.toml", 4, "none.toml");
    refuses("--config unknown.toml", 2, "prot");
    refuses("--config section.toml", 2, "section.toml:2: there is no setting 'server.port'");
    refuses("--config value.toml", 2, "value.toml:3: port: '70000'");
    refuses("--config .", 4, "folder");
    refuses("--config ''", 2, "--config");
    refuses("--data ''", 2, "--data");
    refuses("", 2, "ISOFRONT_SERVE_PROT", "ISOFRONT_SERVE_PROT=80");
    refuses("--host 0.0.0.0", 2, "--tokens");
    refuses("--port 0 --data file/data", 4, "file/data");
    refuses("--port 0 --tokens none", 4, "none");
}

TEST_F(Serve, servesUntilItIsAskedToEnd)
{
    const Service service = start();
    ASSERT_NE(service.port, 0);
    server::HttpClient client(service.port);
    EXPECT_EQ(client.ask("GET", "/healthz").status, 200);
    kill(service.process, SIGTERM);
    int status = -1;
    waitpid(service.process, &status, 0);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0) << contentsOf(folder / "errors");
    EXPECT_TRUE(client.isClosed());
    EXPECT_TRUE(fs::exists(folder / "isofront-data" / "scenes"));
}

TEST_F(Serve, givesAClientTheRestAfterItWasKilled)
{
    Service service = start();
    ASSERT_NE(service.port, 0);
    const server::StreamedScene scene = server::makeScene(service.port);
    server::StreamViewer viewer(service.port, scene.target);
    viewer.greet(scene.view);
    viewer.settle();
    end(service);
    while (viewer.listen()) {
    }
    EXPECT_TRUE(viewer.socket.isClosed());

    std::filesystem::remove(folder / "errors");
    service = start();
    ASSERT_NE(service.port, 0);
    server::StreamViewer again(service.port, scene.target);
    again.greet(scene.view, viewer.client.payloads);
    again.settle();
    EXPECT_GT(again.client.host.triangles(), 500U);
    EXPECT_EQ(again.client.host.triangles(), viewer.client.host.triangles());
    EXPECT_LT(5 * again.client.cells, viewer.client.cells);
    end(service);
}

} // namespace
} // namespace isofront::cli
