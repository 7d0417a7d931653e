#include "HttpClient.h"
#include "TemporaryFolder.h"

#include <isofront/server/Server.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace isofront::server {
namespace {

using Json = nlohmann::ordered_json;

/// The real service on a port of its own.
class Served : public testing::Test {
protected:
    Served()
    {
        settings.port = 0;
        settings.data = folder.path / "data";
        settings.sources = folder.path / "sources";
        settings.logLevel = "error";
        settings.anonymous = {"read", "write", "admin"};
        settings.workers = 4;
        std::filesystem::create_directories(settings.sources);
    }

    void start()
    {
        server.reset();
        auto started = Server::start(settings);
        ASSERT_TRUE(started) << started.error().message;
        server = std::move(*started);
    }

    HttpAnswer
    ask(const std::string& method,
        const std::string& target,
        const std::string& headers = "",
        const std::optional<std::string>& body = {}) const
    {
        HttpClient client(server->port());
        return client.ask(method, target, headers, body);
    }

    /// Asks for a scene until it is ready or has failed.
    Json prepared(const std::string& id) const
    {
        Json scene;
        do {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            scene = Json::parse(ask("GET", "/v1/scenes/" + id).body);
        } while (scene.at("state") == "preparing");
        return scene;
    }

    TemporaryFolder folder;
    Settings settings;
    std::unique_ptr<Server> server;
};

constexpr const char* kBall = R"({"file": "ball.raw", "options": {"raw": "16x16x16,uint8"}})";
constexpr const char* kJson = "Content-Type: application/json\r\n";

TEST_F(Served, tellsOfItsHealth)
{
    start();
    HttpClient client(server->port());
    const HttpAnswer health = client.ask("GET", "/healthz");
    EXPECT_EQ(health.status, 200);
    EXPECT_EQ(Json::parse(health.body).at("status"), "ok");
    EXPECT_EQ(health.headers.at("x-content-type-options"), "nosniff");
    // the connection stays
    const HttpAnswer head = client.ask("HEAD", "/healthz");
    EXPECT_EQ(head.status, 200);
    EXPECT_EQ(head.headers.at("content-length"), std::to_string(health.body.size()));
    const HttpAnswer metrics = client.ask("GET", "/metrics");
    EXPECT_EQ(metrics.status, 200);
    EXPECT_NE(
        metrics.body.find("isofront_requests_total{method=\"GET\",route=\"/healthz\","
                          "status=\"200\"} 1"),
        std::string::npos)
        << metrics.body;
    EXPECT_NE(metrics.body.find("\nisofront_connections 1\n"), std::string::npos);
}

TEST_F(Served, keepsScenesFromFormulaToDeletion)
{
    start();
    const HttpAnswer made =
        ask("POST", "/v1/scenes", kJson, R"({"name": "a ball", "formula": "proc:sphere"})");
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string id = Json::parse(made.body).at("id");
    EXPECT_EQ(made.headers.at("location"), "/v1/scenes/" + id);
    const Json scene = prepared(id);
    EXPECT_EQ(scene.at("state"), "ready") << scene;
    EXPECT_EQ(scene.at("name"), "a ball");
    EXPECT_EQ(scene.at("description").at("histogram").size(), 256U);

    const HttpAnswer list = ask("GET", "/v1/scenes");
    ASSERT_EQ(Json::parse(list.body).at("scenes").size(), 1U);
    const std::string tag = list.headers.at("etag");
    const HttpAnswer unchanged = ask("GET", "/v1/scenes", "If-None-Match: " + tag + "\r\n");
    EXPECT_EQ(unchanged.status, 304);
    EXPECT_TRUE(unchanged.body.empty());

    EXPECT_EQ(ask("DELETE", "/v1/scenes/" + id).status, 204);
    EXPECT_EQ(ask("DELETE", "/v1/scenes/" + id).status, 404);
    EXPECT_EQ(ask("GET", "/v1/scenes/" + id).status, 404);
    EXPECT_EQ(ask("GET", "/v1/scenes", "If-None-Match: " + tag + "\r\n").status, 200);
}

TEST_F(Served, takesUploadsAndKeepsThemOverARestart)
{
    start();
    const std::string volume = ballVolume(32);
    const HttpAnswer made =
        ask("POST", "/v1/uploads?file=ball.raw&name=ball&raw=" + ballLayout(32), "", volume);
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string id = Json::parse(made.body).at("id");
    EXPECT_EQ(Json::parse(made.body).at("stored_bytes"), volume.size());
    const Json before = prepared(id);
    EXPECT_EQ(before.at("description").at("kind"), "volume") << before;
    EXPECT_TRUE(std::filesystem::is_empty(settings.data / "uploads"));
    start();
    EXPECT_EQ(Json::parse(ask("GET", "/v1/scenes/" + id).body), before);
}

TEST_F(Served, takesUploadsInChunksAndAfterAskingFirst)
{
    start();
    const std::string volume = ballVolume(32);
    HttpClient chunked(server->port());
    chunked.send("POST /v1/uploads?file=a.raw HTTP/1.1\r\nHost: localhost\r\n"
                 "Transfer-Encoding: chunked\r\n\r\n");
    for (std::size_t begin = 0; begin < volume.size(); begin += 5000) {
        const std::string piece = volume.substr(begin, 5000);
        char size[16];
        std::snprintf(size, sizeof size, "%zx\r\n", piece.size());
        chunked.send(size + piece + "\r\n");
    }
    chunked.send("0\r\n\r\n");
    const HttpAnswer made = chunked.answer();
    ASSERT_EQ(made.status, 201) << made.body;
    EXPECT_EQ(Json::parse(made.body).at("stored_bytes"), volume.size());

    HttpClient careful(server->port());
    careful.send(
        "POST /v1/uploads?file=a.raw HTTP/1.1\r\nHost: localhost\r\n"
        "Expect: 100-continue\r\nContent-Length: " +
        std::to_string(volume.size()) + "\r\n\r\n");
    EXPECT_EQ(careful.answer().status, 100);
    careful.send(volume);
    EXPECT_EQ(careful.answer().status, 201);
}

TEST_F(Served, refusesWhatIsTooLongAndSaysSo)
{
    settings.headerBytes = 2048;
    settings.bodyBytes = 1024;
    settings.uploadBytes = 10000;
    start();
    EXPECT_EQ(ask("GET", "/healthz", "X: " + std::string(4000, 'a') + "\r\n").status, 431);
    EXPECT_EQ(ask("GET", "/" + std::string(4000, 'a')).status, 431);
    EXPECT_EQ(ask("POST", "/v1/scenes", kJson, std::string(2000, ' ')).status, 413);
    EXPECT_EQ(ask("POST", "/v1/scenes", kJson, std::string(3'000'000, ' ')).status, 413);
    EXPECT_EQ(ask("POST", "/v1/uploads?file=a.raw", "", std::string(3'000'000, 'a')).status, 413);
    EXPECT_EQ(ask("GET", "/healthz", "", std::string(100, 'a')).status, 413);
    HttpClient chunked(server->port());
    chunked.send(
        "POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n"
        "\r\n1000\r\n" +
        std::string(4096, ' ') + "\r\n");
    EXPECT_EQ(chunked.answer().status, 413);
    EXPECT_EQ(ask("GET", "/healthz").status, 200);
    EXPECT_TRUE(std::filesystem::is_empty(settings.data / "uploads"));
}

TEST_F(Served, refusesWhatIsMalformed)
{
    start();
    for (const std::string& bytes :
         {std::string("GARBAGE\r\n\r\n"),
          std::string("GET / HTTP/9.9\r\n\r\n"),
          std::string("GET  / HTTP/1.1\r\n\r\n"),
          std::string("\x16\x03\x01\x02\x00\x01\x00\x01"),
          std::string("GET / HTTP/1.1\r\nHost localhost\r\n\r\n"),
          std::string("POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nContent-Length: -5\r\n\r\n"),
          std::string("POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nContent-Length: "
                      "99999999999999999999999\r\n\r\n"),
          std::string("POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n"
                      "Content-Length: 6\r\n\r\nabcdef"),
          std::string("POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked"
                      "\r\n\r\nzz\r\n"),
          std::string("POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked, "
                      "identity\r\n\r\n"),
          std::string("POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: gzip\r\n"
                      "\r\n"),
          std::string("GET /healthz HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n\r\n"),
          std::string("GET /%2e%2e/etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n"),
          std::string("GET ../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n")}) {
        HttpClient client(server->port());
        client.send(bytes);
        EXPECT_EQ(client.answer().status, 400) << bytes;
    }
    EXPECT_EQ(ask("POST", "/v1/scenes", kJson, "{").status, 400);
    EXPECT_EQ(ask("POST", "/v1/scenes", kJson, R"({"formula": 7})").status, 400);
    EXPECT_EQ(ask("POST", "/v1/scenes", kJson, R"({"formula": "proc:none"})").status, 400);
    EXPECT_EQ(ask("POST", "/v1/scenes", "", R"({"formula": "proc:sphere"})").status, 415);
    EXPECT_EQ(ask("POST", "/v1/uploads?file=a.exe", "", "a").status, 415);
    EXPECT_EQ(ask("POST", "/v1/uploads", "", "a").status, 400);
    EXPECT_EQ(ask("POST", "/v1/uploads?file=a.png&height_scale=.5", "", "a").status, 201);
    EXPECT_EQ(
        ask("POST",
            "/v1/scenes",
            kJson,
            R"({"formula": "proc:sphere?)" + std::string(2000, 'a') + "\"}")
            .status,
        400);
    EXPECT_EQ(ask("PUT", "/v1/scenes").status, 405);
    EXPECT_EQ(ask("BREW", "/v1/scenes").status, 405);
    EXPECT_EQ(ask("GET", "/none").status, 404);
    EXPECT_EQ(ask("GET", "/healthz?x=1").status, 400);
}

TEST_F(Served, isFoundByTheNameThatARequestGivesIt)
{
    start();
    const auto statusOf = [&](const std::string& bytes) {
        HttpClient client(server->port());
        client.send(bytes + "\r\n");
        return client.answer();
    };
    // a target that has the name as well, as proxies are sent, counts
    EXPECT_EQ(statusOf("GET http://localhost/healthz HTTP/1.1\r\nHost: localhost\r\n").status, 200);
    EXPECT_EQ(
        statusOf("GET HTTP://localhost:80/healthz HTTP/1.1\r\nHost: evil.example\r\n").status, 200);
    EXPECT_EQ(
        statusOf("GET http://evil.example/healthz HTTP/1.1\r\nHost: localhost\r\n").status, 421);
    EXPECT_EQ(statusOf("GET http://localhost/none?x=1 HTTP/1.1\r\nHost: a\r\n").status, 404);
    EXPECT_EQ(statusOf("GET http:///healthz HTTP/1.1\r\nHost: localhost\r\n").status, 421);
    EXPECT_EQ(statusOf("GET ftp://localhost/healthz HTTP/1.1\r\nHost: localhost\r\n").status, 400);
    EXPECT_EQ(statusOf("GET /healthz HTTP/1.1\r\n").status, 400);
    EXPECT_EQ(statusOf("GET /healthz HTTP/1.1\r\nHost: evil.example\r\n").status, 421);
    for (const char* const target : {"*", "http://localhost"}) {
        const HttpAnswer all =
            statusOf("OPTIONS " + std::string(target) + " HTTP/1.1\r\nHost: localhost\r\n");
        EXPECT_EQ(all.status, 204) << target;
        EXPECT_EQ(all.headers.at("allow"), "GET, HEAD, POST, DELETE, OPTIONS");
    }
    EXPECT_EQ(statusOf("OPTIONS * HTTP/1.1\r\nHost: evil.example\r\n").status, 421);
    EXPECT_EQ(statusOf("GET * HTTP/1.1\r\nHost: localhost\r\n").status, 400);
}

TEST_F(Served, refusesNamesThatNobodyCanWrite)
{
    start();
    for (const char* const body :
         {R"({"name": "a\u0000b", "formula": "proc:sphere"})",
          R"({"name": "a\nb", "formula": "proc:sphere"})",
          R"({"formula": "proc:sphere\u0000"})",
          R"({"file": "a\u0000.raw"})"})
        EXPECT_EQ(ask("POST", "/v1/scenes", kJson, body).status, 400) << body;
    const std::string target = "/v1/uploads?file=a.raw&raw=2x2x2,uint8&name=";
    for (const char* const name : {"a%00b", "a%0Ab", "%FF"})
        EXPECT_EQ(ask("POST", target + name, "", "12345678").status, 400) << name;
    EXPECT_EQ(ask("POST", target + "%C3%A9", "", "12345678").status, 201);
    EXPECT_EQ(Json::parse(ask("GET", "/v1/scenes").body).at("scenes").size(), 1U);
}

TEST_F(Served, looksAtWhatIsAskedForBeforeTheBodyComes)
{
    start();
    const auto ofHeader = [&](const std::string& query) {
        HttpClient client(server->port());
        client.send(
            "POST /v1/uploads?" + query +
            " HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\nContent-Length: 8\r\n\r\n");
        return client.answer().status;
    };
    EXPECT_EQ(ofHeader("file=a.raw"), 100);
    EXPECT_EQ(ofHeader("file=a.exe"), 415);
    EXPECT_EQ(ofHeader("file=a.raw&grid=density"), 400);
    EXPECT_EQ(ofHeader("file=a.raw&voxel_size=1,2"), 400);
    EXPECT_EQ(ofHeader("file=a.ply&mesh_resolution=1"), 400);
    EXPECT_EQ(ofHeader("file=a.raw&name=" + std::string(300, 'a')), 400);
}

TEST_F(Served, countsUploadsThatAreUnderWay)
{
    settings.storageBytes = 10'000;
    start();
    const auto upload = [](std::size_t bytes) {
        return "POST /v1/uploads?file=a.raw HTTP/1.1\r\nHost: localhost\r\nExpect: "
               "100-continue\r\nContent-Length: " +
               std::to_string(bytes) + "\r\n\r\n";
    };
    {
        HttpClient first(server->port());
        first.send(upload(6000));
        ASSERT_EQ(first.answer().status, 100);
        HttpClient second(server->port());
        second.send(upload(6000));
        EXPECT_EQ(second.answer().status, 507);
        // one that doesn't say how long it is ends where there is no more room
        HttpClient chunked(server->port());
        chunked.send(
            "POST /v1/uploads?file=a.raw HTTP/1.1\r\nHost: localhost\r\n"
            "Transfer-Encoding: chunked\r\n\r\n1388\r\n" +
            std::string(5000, 'a') + "\r\n");
        EXPECT_EQ(chunked.answer().status, 507);
        HttpClient small(server->port());
        small.send(upload(4000));
        EXPECT_EQ(small.answer().status, 100);
        small.send(std::string(4000, 'a'));
        EXPECT_EQ(small.answer().status, 201);
    }
    // the first has gone, and its room is free once the service sees that
    int status = 0;
    do {
        HttpClient third(server->port());
        third.send(upload(6000));
        status = third.answer().status;
    } while (status == 507);
    EXPECT_EQ(status, 100);
}

TEST_F(Served, speaksOfOptionsAsRequestsNameThem)
{
    start();
    const HttpAnswer made = ask("POST", "/v1/uploads?file=a.raw", "", "12345678");
    const Json scene = prepared(Json::parse(made.body).at("id"));
    EXPECT_EQ(scene.at("state"), "failed");
    const std::string why = scene.at("failure");
    EXPECT_NE(why.find("option raw "), std::string::npos) << why;
    EXPECT_EQ(why.find("--"), std::string::npos) << why;
}

TEST_F(Served, answersRequestsThatComeTogetherInTheirOrder)
{
    start();
    HttpClient client(server->port());
    client.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
                "GET /none HTTP/1.1\r\nHost: localhost\r\n\r\n"
                "GET /v1/scenes HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    EXPECT_EQ(client.answer().status, 200);
    EXPECT_EQ(client.answer().status, 404);
    EXPECT_EQ(client.answer().status, 200);
    EXPECT_TRUE(client.isClosed());
}

TEST_F(Served, letsNobodyInWithoutAToken)
{
    settings.anonymous.clear();
    settings.tokens = folder.write(
        "tokens", "read anna 0123456789abcdef0\nread,write,admin bert 0123456789abcdef1\n");
    std::filesystem::permissions(settings.tokens, std::filesystem::perms::owner_read);
    start();
    const std::string anna = "Authorization: Bearer 0123456789abcdef0\r\n";
    const std::string bert = "Authorization: Bearer 0123456789abcdef1\r\n";
    EXPECT_EQ(ask("GET", "/healthz").status, 200);
    const HttpAnswer nobody = ask("GET", "/v1/scenes");
    EXPECT_EQ(nobody.status, 401);
    EXPECT_TRUE(nobody.headers.contains("www-authenticate"));
    EXPECT_EQ(ask("GET", "/v1/scenes", anna).status, 200);
    EXPECT_EQ(ask("GET", "/metrics", anna).status, 403);
    EXPECT_EQ(ask("POST", "/v1/scenes", anna + kJson, R"({"formula": "proc:sphere"})").status, 403);
    EXPECT_EQ(ask("DELETE", "/v1/scenes/1", anna).status, 403);
    EXPECT_EQ(ask("POST", "/v1/scenes", bert + kJson, R"({"formula": "proc:sphere"})").status, 201);
    EXPECT_EQ(ask("GET", "/metrics", bert).status, 200);
}

TEST_F(Served, letsOtherPagesInOnlyIfTold)
{
    const std::string page = "Origin: https://lab.example\r\n";
    const std::string asking = page + "Access-Control-Request-Method: POST\r\n";
    start();
    EXPECT_FALSE(ask("GET", "/v1/scenes", page).headers.contains("access-control-allow-origin"));
    EXPECT_FALSE(
        ask("OPTIONS", "/v1/scenes", asking).headers.contains("access-control-allow-methods"));
    EXPECT_EQ(ask("POST", "/v1/scenes", page + kJson, "{}").status, 403);
    settings.origins = {"https://lab.example"};
    start();
    EXPECT_EQ(
        ask("GET", "/v1/scenes", page).headers.at("access-control-allow-origin"),
        "https://lab.example");
    const HttpAnswer preflight = ask("OPTIONS", "/v1/scenes", asking);
    EXPECT_EQ(preflight.status, 204);
    EXPECT_EQ(preflight.headers.at("access-control-allow-methods"), "GET, HEAD, POST");
    EXPECT_EQ(ask("POST", "/v1/scenes", page + kJson, R"({"formula": "proc:sphere"})").status, 201);
    HttpClient foreign(server->port());
    foreign.send("GET /v1/scenes HTTP/1.1\r\nHost: evil.example\r\n\r\n");
    EXPECT_EQ(foreign.answer().status, 421);
}

TEST_F(Served, turnsAwayWhoIsOneTooMany)
{
    settings.connections = 2;
    start();
    HttpClient first(server->port());
    HttpClient second(server->port());
    EXPECT_EQ(first.ask("GET", "/healthz").status, 200);
    EXPECT_EQ(second.ask("GET", "/healthz").status, 200);
    {
        HttpClient third(server->port());
        const HttpAnswer answer = third.answer();
        EXPECT_EQ(answer.status, 503);
        EXPECT_TRUE(answer.headers.contains("retry-after"));
        EXPECT_TRUE(third.isClosed());
    }
    EXPECT_EQ(first.ask("GET", "/healthz").status, 200);
}

TEST_F(Served, turnsNobodyAwayWithoutAWord)
{
    settings.connections = 1;
    start();
    HttpClient first(server->port());
    EXPECT_EQ(first.ask("GET", "/healthz").status, 200);
    std::vector<std::unique_ptr<HttpClient>> others;
    for (int i = 0; i < 10; ++i)
        others.push_back(std::make_unique<HttpClient>(server->port()));
    for (auto& other : others) {
        EXPECT_EQ(other->answer().status, 503);
        other.reset();
    }
    EXPECT_EQ(first.ask("GET", "/healthz").status, 200);
}

TEST_F(Served, closesIdleConnectionsAndThoseThatNeverCome)
{
    settings.idleSeconds = 1;
    settings.headerSeconds = 1;
    start();
    HttpClient slow(server->port());
    slow.send("GET /heal");
    EXPECT_TRUE(slow.isClosed());
    HttpClient client(server->port());
    EXPECT_EQ(client.ask("GET", "/healthz").status, 200);
    EXPECT_TRUE(client.isClosed());
}

TEST_F(Served, drainsWhatIsUnderWay)
{
    start();
    const std::string volume = ballVolume(32);
    HttpClient idle(server->port());
    EXPECT_EQ(idle.ask("GET", "/healthz").status, 200);
    HttpClient busy(server->port());
    busy.send(
        "POST /v1/uploads?file=a.raw HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\n"
        "Content-Length: " +
        std::to_string(volume.size()) + "\r\n\r\n");
    ASSERT_EQ(busy.answer().status, 100);
    std::atomic<bool> isDone = false;
    std::thread drain([&] {
        EXPECT_TRUE(server->drain());
        isDone = true;
    });
    EXPECT_TRUE(idle.isClosed());
    EXPECT_FALSE(isDone);
    const HttpClient late(server->port());
    EXPECT_FALSE(late.isOpen());
    busy.send(volume);
    const HttpAnswer answer = busy.answer();
    EXPECT_EQ(answer.status, 201) << answer.body;
    EXPECT_EQ(answer.headers.at("connection"), "close");
    drain.join();
    EXPECT_TRUE(isDone);
}

TEST_F(Served, endsInTimeWhoeverStays)
{
    settings.drainSeconds = 0.2;
    start();
    HttpClient busy(server->port());
    busy.send("POST /v1/uploads?file=a.raw HTTP/1.1\r\nHost: localhost\r\n"
              "Expect: 100-continue\r\nContent-Length: 1000\r\n\r\n");
    ASSERT_EQ(busy.answer().status, 100);
    EXPECT_FALSE(server->drain());
    server.reset();
    EXPECT_TRUE(busy.isClosed());
    EXPECT_TRUE(std::filesystem::is_empty(settings.data / "uploads"));
}

/// Whatever is being sent while it ends, nothing of it is touched afterwards (for the sanitizers).
TEST_F(Served, endsWhileClientsSend)
{
    settings.drainSeconds = 0.1;
    for (int round = 0; round < 5; ++round) {
        start();
        std::atomic<bool> isOver = false;
        std::atomic<int> sending = 0;
        std::vector<std::thread> clients;
        for (int i = 0; i < 4; ++i)
            clients.emplace_back([&isOver, &sending, port = server->port()] {
                HttpClient client(port);
                client.send("POST /v1/uploads?file=a.raw HTTP/1.1\r\nHost: localhost\r\n"
                            "Expect: 100-continue\r\nContent-Length: 4000000000\r\n\r\n");
                EXPECT_EQ(client.answer().status, 100);
                ++sending;
                while (!isOver && client.send(std::string(100'000, 'a')))
                    ;
            });
        while (sending < 4)
            std::this_thread::yield();
        EXPECT_FALSE(server->drain());
        server.reset();
        isOver = true;
        for (std::thread& client : clients)
            client.join();
        EXPECT_TRUE(std::filesystem::is_empty(settings.data / "uploads"));
    }
}

TEST_F(Served, keepsItsPromisesToManyAtOnce)
{
    start();
    std::vector<std::thread> clients;
    std::atomic<int> good = 0;
    for (int i = 0; i < 8; ++i)
        clients.emplace_back([&] {
            HttpClient client(server->port());
            for (int round = 0; round < 5; ++round) {
                const HttpAnswer made =
                    client.ask("POST", "/v1/scenes", kJson, R"({"formula": "proc:sphere"})");
                if (made.status != 201)
                    continue;
                const std::string id = Json::parse(made.body).at("id");
                const bool isListed =
                    client.ask("GET", "/v1/scenes").body.find(id) != std::string::npos;
                good += isListed && client.ask("DELETE", "/v1/scenes/" + id).status == 204 ? 1 : 0;
            }
        });
    for (std::thread& client : clients)
        client.join();
    EXPECT_EQ(good, 40);
    EXPECT_EQ(Json::parse(ask("GET", "/v1/scenes").body).at("scenes").size(), 0U);
}

/// Each operation of the description is there, takes what it says, and answers as it says.
TEST_F(Served, isAsItsDescriptionSays)
{
    folder.write("sources/ball.raw", ballVolume(16));
    start();
    const Json document = Json::parse(ask("GET", "/openapi.json").body);
    EXPECT_EQ(document.at("openapi"), "3.1.0");
    const std::string id = Json::parse(ask("POST", "/v1/scenes", kJson, kBall).body).at("id");
    prepared(id);
    std::size_t operations = 0;
    std::vector<std::pair<std::string, std::string>> last; // what deletes comes last
    const auto check = [&](const std::string& path, const std::string& method) {
        ++operations;
        const Json& operation = document.at("paths").at(path).at(method);
        std::string target = path;
        if (const std::size_t at = target.find("{id}"); at != std::string::npos)
            target.replace(at, 4, id);
        std::string query;
        for (const Json& parameter : operation.value("parameters", Json::array()))
            if (parameter.at("in") == "query" && parameter.at("required") == true)
                query += (query.empty() ? "?" : "&") + parameter.at("name").get<std::string>() +
                         "=" + (parameter.at("name") == "file" ? "ball.raw" : "1");
        std::optional<std::string> body;
        std::string headers;
        if (operation.contains("requestBody")) {
            const std::string type = operation.at("requestBody").at("content").begin().key();
            headers = "Content-Type: " + type + "\r\n";
            body = type == "application/json" ? kBall : ballVolume(8);
            const Json& content = operation["requestBody"]["content"][type];
            if (const Json named = content.value("schema", Json::object()); !named.empty()) {
                const std::string schema = named.at("$ref");
                const Json& described = document.at("components")
                                            .at("schemas")
                                            .at(schema.substr(schema.rfind('/') + 1));
                if (described.contains("examples"))
                    body = described["examples"].front().dump();
            }
        }
        std::string verb;
        for (const char c : method)
            verb += static_cast<char>(c - 'a' + 'A');
        const HttpAnswer answer = ask(verb, target + query, headers, body);
        const std::string status = std::to_string(answer.status);
        ASSERT_TRUE(operation.at("responses").contains(status))
            << verb << " " << target << " " << status << " " << answer.body;
        const Json& response = operation.at("responses").at(status);
        if (!response.contains("content"))
            return;
        const std::string type = response.at("content").begin().key();
        EXPECT_TRUE(answer.headers.at("content-type").starts_with(type)) << target;
        if (type != "application/json" || !response["content"][type].contains("schema"))
            return;
        // what it answers has what the schema says, and nothing else
        const std::string reference = response["content"][type]["schema"]["$ref"];
        const Json& schema =
            document.at("components").at("schemas").at(reference.substr(reference.rfind('/') + 1));
        const Json content = Json::parse(answer.body);
        for (const auto& [name, value] : content.items())
            EXPECT_TRUE(schema.at("properties").contains(name)) << target << " " << name;
        for (const Json& name : schema.value("required", Json::array()))
            EXPECT_TRUE(content.contains(name.get<std::string>())) << target << " " << name;
    };
    for (const auto& [path, methods] : document.at("paths").items())
        for (const auto& [method, operation] : methods.items())
            if (method == "delete")
                last.emplace_back(path, method);
            else
                check(path, method);
    for (const auto& [path, method] : last)
        check(path, method);
    EXPECT_GE(operations, 10U);
}

TEST(Server, saysWhyItCantStart)
{
    const TemporaryFolder folder;
    Settings settings;
    settings.port = 0;
    settings.logLevel = "error";
    settings.data = folder.path / "data";
    const auto first = Server::start(settings);
    ASSERT_TRUE(first) << first.error().message;
    Settings same = settings;
    same.port = (*first)->port();
    same.data = folder.path / "other";
    Settings sameFolder = settings;
    const auto second = Server::start(sameFolder);
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().message.find("another service uses it"), std::string::npos);
    const auto taken = Server::start(same);
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error().code, core::ErrorCode::inputOutput);
    EXPECT_NE(taken.error().message.find(std::to_string(same.port)), std::string::npos);
    Settings nowhere = settings;
    nowhere.host = "192.0.2.1"; // an address for documents: nobody's
    EXPECT_FALSE(Server::start(nowhere));
    Settings unwritable = settings;
    unwritable.data = folder.write("file", "") / "data";
    const auto refused = Server::start(unwritable);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("data"), std::string::npos);
    Settings sources = settings;
    sources.data = folder.path / "third";
    sources.sources = folder.path / "none";
    EXPECT_FALSE(Server::start(sources));
    Settings tokens = settings;
    tokens.tokens = folder.path / "none";
    EXPECT_FALSE(Server::start(tokens));
}

} // namespace
} // namespace isofront::server
