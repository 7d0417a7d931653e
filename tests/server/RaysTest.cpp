#include "queries/Rays.h"

#include "HttpClient.h"
#include "TemporaryFolder.h"
#include "http/Interest.h"

#include <isofront/server/Server.h>
#include <isofront/surface/MeshExtraction.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <thread>

namespace isofront::server {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kJson = "Content-Type: application/json\r\n";

sources::Source sourceOf(const std::string& formula)
{
    auto source = sources::openSource(formula, {});
    EXPECT_TRUE(source) << source.error().message;
    return std::move(*source);
}

TEST(Rays, meetTheMeshThatIsExtracted)
{
    const sources::Source source = sourceOf("proc:torus?ring=0.75&tube=0.3");
    const auto jobs = core::makeJobs();
    extractor::ExtractionSettings settings;
    settings.latticeSize = 8;
    surface::MeshExtractionOptions options;
    options.detail.level = 12;
    const auto mesh = surface::extractMesh(
        std::make_shared<const extractor::CellExtractor>(source.field, source.domain, settings),
        *jobs,
        options);
    ASSERT_TRUE(mesh);
    const surface::TriangleMesh& torus = mesh->mesh;
    ASSERT_GT(torus.positions.size(), 500U);
    std::vector<WorldRay> rays;
    for (std::size_t i = 0; i < torus.positions.size(); ++i)
        rays.push_back(
            {torus.positions[i] + 0.1 * glm::dvec3(torus.normals[i]),
             -3.0 * glm::dvec3(torus.normals[i])});
    const auto hits = castRays(source, 0, rays, *jobs, {});
    ASSERT_TRUE(hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_TRUE((*hits)[i].has_value());
        const WorldHit& hit = *(*hits)[i];
        // a vertex is off the surface by no more than a lattice step's sagitta
        EXPECT_NEAR(hit.distance, 0.1, 5e-3);
        EXPECT_LT(glm::distance(hit.point, torus.positions[i]), 5e-3);
        ASSERT_TRUE(hit.normal.has_value());
        EXPECT_GT(glm::dot(*hit.normal, glm::dvec3(torus.normals[i])), 0.999);
    }
}

/// All lengths are those of the world, whatever the voxels' size and direction.
TEST(Rays, areOfTheWorld)
{
    const TemporaryFolder folder;
    const auto file = folder.write("ball.raw", ballVolume(32));
    sources::SourceOptions options;
    options.rawLayout = ballLayout(32);
    options.voxelSize = glm::dvec3(0.5, 1, 2);
    const auto source = sources::openSource(file.string(), options);
    ASSERT_TRUE(source) << source.error().message;
    const auto jobs = core::makeJobs();
    const glm::dvec3 centre = source->worldBox.centre();
    const glm::dvec3 radius = std::sqrt(0.1) * 32.0 * glm::dvec3(0.5, 1, 2);
    for (glm::length_t axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
            WorldRay ray{centre, glm::dvec3(0.0)};
            ray.origin[axis] -= side * 200;
            ray.direction[axis] = side * 1e-3;
            const auto hits = castRays(*source, 100, {&ray, 1}, *jobs, {});
            ASSERT_TRUE(hits && hits->front());
            const WorldHit& hit = *hits->front();
            EXPECT_NEAR(hit.distance, 200 - radius[axis], glm::dvec3(0.5, 1, 2)[axis]);
            EXPECT_NEAR(glm::distance(hit.point, ray.origin), hit.distance, 1e-9);
            ASSERT_TRUE(hit.normal.has_value());
            EXPECT_LT((*hit.normal)[axis] * side, -0.99);
        }
}

TEST(Rays, areGivenUpWhenAsked)
{
    const sources::Source source = sourceOf("proc:sphere");
    const auto jobs = core::makeJobs();
    std::stop_source stop;
    stop.request_stop();
    const std::vector<WorldRay> rays(100, WorldRay{{-3, 0, 0}, {1, 0, 0}});
    const auto hits = castRays(source, 0, rays, *jobs, stop.get_token());
    ASSERT_FALSE(hits);
    EXPECT_EQ(hits.error().code, core::ErrorCode::interrupted);
}

class RaysOfAService : public testing::Test {
protected:
    RaysOfAService()
    {
        Settings settings;
        settings.port = 0;
        settings.data = folder.path / "data";
        settings.logLevel = "error";
        settings.anonymous = {"read", "write"};
        settings.workers = 2;
        auto started = Server::start(settings);
        EXPECT_TRUE(started) << started.error().message;
        server = std::move(*started);
    }

    HttpAnswer post(const std::string& target, const std::string& body) const
    {
        return HttpClient(server->port()).ask("POST", target, kJson, body);
    }

    /// @return the path of a scene that is ready
    std::string make(const std::string& formula) const
    {
        const HttpAnswer made = post("/v1/scenes", Json{{"formula", formula}}.dump());
        EXPECT_EQ(made.status, 201) << made.body;
        const std::string path = made.headers.at("location");
        while (Json::parse(HttpClient(server->port()).ask("GET", path).body).at("state") ==
               "preparing")
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return path;
    }

    TemporaryFolder folder;
    std::unique_ptr<Server> server;
};

TEST_F(RaysOfAService, saysWhereTheyHit)
{
    const std::string scene = make("proc:sphere?radius=2");
    const HttpAnswer answer = post(
        scene + "/rays",
        R"({"isovalue": 0.5, "rays": [[0,0,9,0,0,-2], [9,0,0,0,1,0], [0,0,0,1e-9,0,0]]})");
    ASSERT_EQ(answer.status, 200) << answer.body;
    const Json json = Json::parse(answer.body);
    EXPECT_EQ(json.at("isovalue"), 0.5);
    const Json& hits = json.at("hits");
    ASSERT_EQ(hits.size(), 3U);
    EXPECT_NEAR(hits[0].at("distance").get<double>(), 7.5, 1e-6);
    EXPECT_NEAR(hits[0].at("point")[2].get<double>(), 1.5, 1e-6);
    EXPECT_NEAR(hits[0].at("normal")[2].get<double>(), 1, 1e-6);
    EXPECT_TRUE(hits[1].is_null());
    // from within
    EXPECT_NEAR(hits[2].at("point")[0].get<double>(), 1.5, 1e-6);
    EXPECT_NEAR(hits[2].at("normal")[0].get<double>(), 1, 1e-6);
}

TEST_F(RaysOfAService, saysHowHighTheSurfaceIs)
{
    const std::string scene = make("proc:plane?x=0.1&y=0.2&z=1");
    const HttpAnswer answer =
        post(scene + "/heights", R"({"points": [[0,0,0], [0.5,0.25,77], [900,0,0]]})");
    ASSERT_EQ(answer.status, 200) << answer.body;
    const Json json = Json::parse(answer.body);
    EXPECT_EQ(json.at("up"), (Json{0.0, 0.0, 1.0}));
    EXPECT_NEAR(json.at("heights")[0].get<double>(), 0, 1e-9);
    EXPECT_NEAR(json.at("heights")[1].get<double>(), -0.1, 1e-9);
    EXPECT_TRUE(json.at("heights")[2].is_null());
}

TEST_F(RaysOfAService, refusesWhatMakesNoSense)
{
    const std::string scene = make("proc:sphere");
    for (const char* const body :
         {"",
          "[]",
          "{}",
          R"({"rays": 7})",
          R"({"rays": [7]})",
          R"({"rays": [[0,0,0,1,0]]})",
          R"({"rays": [[0,0,0,1,0,"0"]]})",
          R"({"rays": [[0,0,0,1,0,1e999]]})",
          R"({"rays": [[0,0,0,1,0,1e300]]})",
          R"({"rays": [[0,0,0,0,0,0]]})",
          R"({"rays": [], "isovalue": null})",
          R"({"rays": [], "points": []})"})
        EXPECT_EQ(post(scene + "/rays", body).status, 400) << body;
    std::string many = R"({"rays": [[0,0,0,1,0,0])";
    for (int i = 0; i < 10'000; ++i)
        many += ",[0,0,0,1,0,0]";
    EXPECT_EQ(post(scene + "/rays", many + "]}").status, 413);
    EXPECT_EQ(post("/v1/scenes/none/rays", R"({"rays": []})").status, 404);
    EXPECT_EQ(
        HttpClient(server->port()).ask("POST", scene + "/rays", "", R"({"rays": []})").status, 415);
    EXPECT_EQ(Json::parse(post(scene + "/rays", R"({"rays": []})").body).at("hits"), Json::array());
}

/// A connection, and its client.
struct Line {
    explicit Line(net::io_context& context) : client(context), served(context)
    {
        tcp::acceptor acceptor(context, {net::ip::address_v4::loopback(), 0});
        client.connect(acceptor.local_endpoint());
        acceptor.accept(served);
    }

    tcp::socket client;
    tcp::socket served;
};

TEST(Interest, endsWhenTheClientHangsUp)
{
    net::io_context context;
    Line line(context);
    const Interest interest(line.served, 3600, {});
    context.poll();
    EXPECT_FALSE(interest.token().stop_requested());
    line.client.close();
    while (!interest.token().stop_requested() && context.run_one() > 0) {
    }
    EXPECT_TRUE(interest.token().stop_requested());
}

TEST(Interest, endsWhenItTakesTooLong)
{
    net::io_context context;
    Line line(context);
    const Interest interest(line.served, 0.001, {});
    while (!interest.token().stop_requested() && context.run_one() > 0) {
    }
    EXPECT_TRUE(interest.token().stop_requested());
}

TEST(Interest, endsWithTheService)
{
    net::io_context context;
    Line line(context);
    std::stop_source service;
    const Interest interest(line.served, 3600, service.get_token());
    service.request_stop();
    EXPECT_TRUE(interest.token().stop_requested());
}

/// Somebody who has sent the next request already wants the answer to this one.
TEST(Interest, lastsWhereMoreWasSent)
{
    net::io_context context;
    Line line(context);
    std::optional<Interest> interest(std::in_place, line.served, 3600, std::stop_token());
    const std::stop_token token = interest->token();
    line.client.send(net::buffer("next", 4));
    context.run_one(); // there is something to read
    EXPECT_FALSE(token.stop_requested());
    // and nothing is waited for any more
    interest.reset();
    context.run();
    EXPECT_FALSE(token.stop_requested());
}

} // namespace
} // namespace isofront::server
