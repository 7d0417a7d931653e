#include "StreamClient.h"
#include "stream/StreamSession.h"
#include "support/Random.h"

#include <isofront/hierarchy/Front.h>

#include <glm/trigonometric.hpp>

#include <algorithm>
#include <array>
#include <thread>

namespace isofront::server {
namespace {

using surface::Hills;
using surface::viewFrom;

constexpr double kError = 12; // coarse, so that tests are quick [px]
constexpr std::uint64_t kPlenty = std::uint64_t{1} << 30U;

/// A session without transport or threads.
struct Talk {
    explicit Talk(
        const std::shared_ptr<surface::SharedCells>& shared = nullptr, bool isNegated = false)
    {
        sources::Source source;
        source.field = std::make_shared<Hills>();
        source.negated = isNegated;
        source.worldBox = {glm::dvec3(0), glm::dvec3(1)};
        StreamSession::Setup setup;
        setup.scene = std::make_shared<const OpenScene>(OpenScene{{}, source});
        setup.surface = surface::smallOptions();
        setup.surface.shared = shared;
        setup.jobs = surface::jobsOf(core::JobsBackend::inlined);
        setup.payloads = std::make_shared<SharedPayloads>(std::size_t{1} << 20U);
        setup.metrics = &metrics;
        session = std::make_unique<StreamSession>(std::move(setup));
    }

    void say(const std::vector<std::byte>& message)
    {
        if (!message.empty() && message[0] >= std::byte{2} && message[0] <= std::byte{4})
            client.isSettled = false; // another wish
        session->receive(message);
    }
    void greet(const std::map<std::uint64_t, std::uint32_t>& held = {})
    {
        say(helloMessage(kPlenty, held));
    }
    /// Takes what there is.
    /// @return whether there was anything
    bool listen()
    {
        bool any = false;
        while (const auto message = session->next()) {
            any = true;
            const std::uint64_t before = client.transaction;
            client.take(*message);
            if (acknowledges && client.transaction != before)
                say(acknowledgeMessage(client.transaction));
            if (testing::Test::HasFailure())
                break;
        }
        return any;
    }
    /// Until the client has all that its wishes lead to.
    void settle()
    {
        for (int i = 0; i < 20000 && !client.isSettled && !testing::Test::HasFailure(); ++i) {
            session->advance();
            listen();
        }
        ASSERT_TRUE(client.isSettled);
    }

    Metrics metrics;
    StreamClient client;
    bool acknowledges = true;
    std::unique_ptr<StreamSession> session;
};

/// What an extractor makes of the cells that are shown.
void expectMeshesOf(const StreamClient& client, double isovalue)
{
    extractor::ExtractionSettings settings = surface::smallOptions().extraction;
    settings.isovalue = isovalue;
    const extractor::CellExtractor extractor(std::make_shared<Hills>(), {}, settings);
    ASSERT_GT(client.host.cells().size(), 20U);
    for (const auto& [id, mesh] : client.host.cells()) {
        const auto expected = extractor.extract(hierarchy::tetrahedronOf(id));
        const auto trianglesOf = [](const extractor::CellMesh& of) {
            std::vector<std::array<std::array<std::uint16_t, 3>, 3>> triangles;
            for (std::size_t i = 0; i < of.indices.size(); i += 3) {
                triangles.push_back(
                    {of.vertices[of.indices[i]].position,
                     of.vertices[of.indices[i + 1]].position,
                     of.vertices[of.indices[i + 2]].position});
                std::ranges::rotate(triangles.back(), std::ranges::min_element(triangles.back()));
            }
            std::ranges::sort(triangles);
            return triangles;
        };
        ASSERT_EQ(mesh->low, expected->low);
        ASSERT_EQ(mesh->exponent, expected->exponent);
        ASSERT_EQ(trianglesOf(*mesh), trianglesOf(*expected));
    }
}

TEST(CellCodec, keepsPositionsAndNearlyNormals)
{
    for (const int lattice : {4, 8, 16}) {
        extractor::ExtractionSettings settings;
        settings.latticeSize = lattice;
        const extractor::CellExtractor extractor(std::make_shared<Hills>(), {}, settings);
        hierarchy::Front front;
        for (int level = 0; level < 9; ++level) {
            std::vector<hierarchy::LatticePoint> centres;
            front.forEachDiamond([&](const hierarchy::LatticePoint& centre) {
                if (!front.isSplit(centre) && front.isComplete(centre))
                    centres.push_back(centre);
            });
            for (const auto& centre : centres)
                front.split(centre);
        }
        std::size_t bytes = 0;
        std::size_t triangles = 0;
        double worst = 1;
        front.forEachCell([&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
            if (triangles > 6'000)
                return;
            auto mesh = *extractor.extract(cell);
            if (mesh.indices.empty())
                return;
            if (triangles % 2 == 0)
                for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
                    mesh.attributes.push_back(static_cast<std::uint32_t>(i / 7 + 13));
            const CellPayload payload = encodeCell(mesh);
            if (mesh.attributes.empty()) {
                bytes += payload.bytes.size();
                triangles += mesh.triangleCount();
            } else {
                ++triangles;
            }
            const auto read = decodeCell(payload.bytes);
            ASSERT_TRUE(read) << read.error().message;
            ASSERT_EQ(read->low, mesh.low);
            ASSERT_EQ(read->exponent, mesh.exponent);
            ASSERT_EQ(read->indices.size(), mesh.indices.size());
            // vertices lie where they lay; those at one place may differ in their normals
            using Corner = std::pair<std::array<std::uint16_t, 3>, std::uint32_t>;
            std::multimap<Corner, glm::dvec3> normals;
            for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
                normals.emplace(
                    Corner{
                        mesh.vertices[i].position,
                        mesh.attributes.empty() ? 0U : mesh.attributes[i]},
                    extractor::fromOctahedral(mesh.vertices[i].normal));
            for (std::size_t i = 0; i < read->vertices.size(); ++i) {
                const auto [begin, end] = normals.equal_range(
                    {read->vertices[i].position,
                     read->attributes.empty() ? 0U : read->attributes[i]});
                double best = -1;
                for (auto it = begin; it != end; ++it)
                    best = std::max(
                        best,
                        glm::dot(it->second, extractor::fromOctahedral(read->vertices[i].normal)));
                worst = std::min(worst, best);
            }
        });
        EXPECT_LE(glm::degrees(std::acos(worst)), kNormalDegrees) << lattice;
        RecordProperty(
            "bytes_per_triangle_" + std::to_string(lattice),
            std::to_string(double(bytes) / double(triangles)));
        if (lattice >= 8) {
            EXPECT_LT(double(bytes) / double(triangles), 6.0) << lattice;
        }
    }
}

TEST(CellCodec, refusesBytesThatAreNoCell)
{
    extractor::ExtractionSettings settings;
    settings.latticeSize = 4;
    const extractor::CellExtractor extractor(std::make_shared<Hills>(), {}, settings);
    CellPayload payload;
    hierarchy::Front front;
    front.forEachCell([&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
        if (const auto mesh = extractor.extract(cell); !mesh->indices.empty())
            payload = encodeCell(*mesh);
    });
    ASSERT_FALSE(payload.bytes.empty());
    for (std::size_t size = 0; size < payload.bytes.size(); ++size)
        ASSERT_FALSE(decodeCell(std::span(payload.bytes).first(size))) << size;
    auto generator = tests::random(5);
    for (int i = 0; i < tests::trials(5000); ++i) {
        auto bytes = payload.bytes;
        for (std::size_t k = 0; k < 1 + tests::below(generator, 4); ++k)
            bytes[tests::below(generator, bytes.size())] =
                static_cast<std::byte>(tests::below(generator, 256));
        if (const auto mesh = decodeCell(bytes)) {
            ASSERT_LT(*std::ranges::max_element(mesh->indices), mesh->vertices.size());
        }
    }
}

TEST(SharedPayloads, encodeAMeshOnceAndStayBelowTheirBound)
{
    extractor::ExtractionSettings settings;
    settings.latticeSize = 4;
    const extractor::CellExtractor extractor(std::make_shared<Hills>(), {}, settings);
    std::vector<std::shared_ptr<const extractor::CellMesh>> meshes;
    hierarchy::Front().forEachCell(
        [&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
            if (auto mesh = extractor.extract(cell); !mesh->indices.empty())
                meshes.push_back(std::make_shared<const extractor::CellMesh>(std::move(*mesh)));
        });
    ASSERT_GT(meshes.size(), 2U);
    SharedPayloads all(std::size_t{1} << 20U);
    for (const auto& mesh : meshes) {
        const auto payload = all.encoded(mesh);
        EXPECT_EQ(payload->bytes, encodeCell(*mesh).bytes);
        EXPECT_EQ(payload->hash, hashOf(payload->bytes));
        EXPECT_EQ(all.encoded(mesh), payload);
    }
    EXPECT_EQ(all.stats().encoded, meshes.size());
    EXPECT_EQ(all.stats().shared, meshes.size());

    SharedPayloads few(all.stats().bytes - 1); // the least recently used goes
    for (const auto& mesh : meshes)
        static_cast<void>(few.encoded(mesh));
    EXPECT_LT(few.stats().bytes, all.stats().bytes);
    static_cast<void>(few.encoded(meshes.back()));
    EXPECT_EQ(few.stats().shared, 1U);
    static_cast<void>(few.encoded(meshes.front()));
    EXPECT_EQ(few.stats().encoded, meshes.size() + 1);

    SharedPayloads none(0);
    EXPECT_EQ(none.encoded(meshes[0])->bytes, all.encoded(meshes[0])->bytes);
    EXPECT_EQ(none.stats().bytes, 0U);
}

// Where one mesh lay there may be another: places alone don't tell them apart.
TEST(SharedPayloads, areNotTakenForThoseOfMeshesThatHaveGone)
{
    extractor::ExtractionSettings settings;
    settings.latticeSize = 4;
    const extractor::CellExtractor extractor(std::make_shared<Hills>(), {}, settings);
    extractor::CellMesh place;
    const auto at = [&] { // all at one address
        return std::shared_ptr<const extractor::CellMesh>(
            &place, [](const extractor::CellMesh*) {});
    };
    SharedPayloads payloads(std::size_t{1} << 20U);
    std::size_t count = 0;
    hierarchy::Front().forEachCell(
        [&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
            place = *extractor.extract(cell);
            if (place.indices.empty())
                return;
            ++count;
            EXPECT_EQ(payloads.encoded(at())->bytes, encodeCell(place).bytes);
        });
    EXPECT_GT(count, 2U);
    EXPECT_EQ(payloads.stats().encoded, count);
}

TEST(StreamSession, leadsAClientWithoutCracksToTheSurface)
{
    Talk talk;
    talk.greet();
    talk.say(creditsMessage(kPlenty));
    talk.listen();
    EXPECT_TRUE(talk.client.isWelcomed);
    EXPECT_EQ(talk.client.transaction, 0U);
    talk.say(viewMessage(viewFrom({0.4, 0.3, 0.65}), kError));
    talk.settle();
    expectMeshesOf(talk.client, 0);
    for (int i = 0; i < 12; ++i) { // a walk
        talk.say(viewMessage(viewFrom({0.4 + 0.03 * i, 0.3, 0.65}), kError));
        talk.session->advance();
        talk.listen();
    }
    talk.settle();
    expectMeshesOf(talk.client, 0);
    EXPECT_LT(double(talk.client.received), 9.0 * double(talk.client.cellTriangles));
}

TEST(StreamSession, changesTheIsovalueInOneTransaction)
{
    Talk talk(nullptr, true);
    talk.greet();
    talk.say(creditsMessage(kPlenty));
    talk.say(viewMessage(viewFrom({0.4, 0.3, 0.65}), kError));
    talk.settle();
    talk.say(isovalueMessage(0.03)); // the field's own is -0.03: the source is turned round
    for (int i = 0; i < 20000 && talk.client.isovalue == 0; ++i) {
        talk.session->advance();
        const auto message = talk.session->next();
        if (message)
            talk.client.take(*message);
    }
    EXPECT_EQ(talk.client.isovalue, 0.03);
    expectMeshesOf(talk.client, -0.03);
    talk.acknowledges = false;
    talk.say(acknowledgeMessage(talk.client.transaction));
    talk.acknowledges = true;
    talk.settle();
    expectMeshesOf(talk.client, -0.03);
}

TEST(StreamSession, tellsOfAnIsovalueThatChangesNoCell)
{
    Talk talk(nullptr, true);
    talk.greet();
    talk.say(creditsMessage(kPlenty));
    talk.say(viewMessage(viewFrom({0.4, 0.3, 0.65}), kError));
    for (const double isovalue : {1e6, 2e6, -1e6}) { // there is nothing at any of them
        talk.say(isovalueMessage(isovalue));
        for (int i = 0; i < 20000 && talk.client.isovalue != isovalue; ++i) {
            talk.session->advance();
            const auto message = talk.session->next();
            if (message)
                talk.client.take(*message);
        }
        EXPECT_EQ(talk.client.isovalue, isovalue);
        talk.acknowledges = false;
        talk.say(acknowledgeMessage(talk.client.transaction));
        talk.acknowledges = true;
        talk.settle();
        EXPECT_EQ(talk.client.host.triangles(), 0U);
    }
}

TEST(StreamSession, neverSendsMoreThanItsCredits)
{
    Talk talk;
    talk.greet();
    talk.say(viewMessage(viewFrom({0.4, 0.3, 0.65}), kError));
    auto generator = tests::random(11);
    std::uint64_t credits = 0;
    for (int i = 0; i < 100'000 && !talk.client.isSettled; ++i) {
        talk.session->advance();
        talk.listen();
        ASSERT_LE(talk.client.charged, credits);
        const std::uint64_t more = tests::below(generator, 1500);
        talk.say(creditsMessage(more));
        credits += more;
    }
    ASSERT_TRUE(talk.client.isSettled);
    expectMeshesOf(talk.client, 0);
}

TEST(StreamSession, skipsWhatIsSupersededForASlowClient)
{
    Talk slow;
    Talk quick;
    for (Talk* talk : {&slow, &quick}) {
        talk->greet();
        for (int i = 0; i < 12; ++i) {
            talk->say(viewMessage(viewFrom({0.2 + 0.05 * i, 0.3, 0.62}), kError));
            talk->say(creditsMessage(talk == &slow ? 300 : kPlenty));
            talk->session->advance();
            talk->listen();
            if (talk == &quick)
                talk->settle();
        }
        talk->say(creditsMessage(kPlenty));
        talk->settle();
    }
    ASSERT_EQ(slow.client.host.cells().size(), quick.client.host.cells().size());
    EXPECT_LT(slow.client.cells, quick.client.cells);
}

TEST(StreamSession, sendsAReturningClientOnlyTheRest)
{
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.65});
    const auto cells = std::make_shared<surface::SharedCells>(std::size_t{64} << 20U);
    Talk first(cells);
    first.greet();
    first.say(creditsMessage(kPlenty));
    first.say(viewMessage(view, kError));
    first.settle();
    const auto extracted = cells->stats().extracted;
    std::map<std::uint64_t, std::uint32_t> held;
    for (const auto& [hash, payload] : first.client.payloads)
        held[hash] = payload.bytes;

    Talk second(cells);
    second.client.payloads = first.client.payloads;
    first.session.reset();
    second.greet(held);
    second.say(creditsMessage(kPlenty));
    second.say(viewMessage(view, kError));
    second.settle();
    EXPECT_LT(10 * second.client.cells, first.client.cells);
    EXPECT_EQ(second.client.host.cells().size(), first.client.host.cells().size());
    EXPECT_LT(10 * (cells->stats().extracted - extracted), extracted);
}

TEST(StreamSession, tellsAClientWhatItNeedNotKeep)
{
    Talk talk;
    talk.say(helloMessage(5'000));
    talk.say(creditsMessage(kPlenty));
    for (const double x : {0.2, 0.5, 0.8, 0.2}) {
        talk.say(viewMessage(viewFrom({x, 0.3, 0.62}), kError));
        talk.settle();
        std::map<const extractor::CellMesh*, bool> shown;
        for (const auto& [id, mesh] : talk.client.host.cells())
            shown[mesh.get()] = true;
        std::uint64_t idle = 0;
        for (const auto& [hash, payload] : talk.client.payloads)
            idle += shown.contains(payload.mesh.get()) ? 0U : payload.bytes;
        EXPECT_LE(idle, 5'000U);
    }
}

TEST(StreamSession, waitsForAClientThatDoesNotAcknowledge)
{
    Talk talk;
    talk.acknowledges = false;
    talk.greet();
    talk.say(creditsMessage(kPlenty));
    for (int i = 0; i < 200; ++i) {
        // each view on its own would lead to a transaction
        talk.say(viewMessage(viewFrom({0.3 + 0.001 * i, 0.3, 0.65}), kError));
        for (int k = 0; k < 20; ++k) {
            talk.session->advance();
            talk.listen();
        }
    }
    EXPECT_EQ(talk.client.transaction, 4U);
    talk.acknowledges = true;
    talk.say(acknowledgeMessage(4));
    talk.settle();
    EXPECT_GT(talk.client.transaction, 4U);
}

TEST(StreamSession, endsWithAReasonWhereAMessageMakesNoSense)
{
    const auto refused = [](const std::vector<std::byte>& message, bool greets) {
        Talk talk;
        if (greets)
            talk.greet();
        talk.say(message);
        talk.listen();
        EXPECT_TRUE(talk.session->isOver());
        EXPECT_FALSE(talk.client.error.empty());
        talk.say(creditsMessage(1)); // nobody listens any more
        EXPECT_FALSE(talk.session->next());
        return talk.client.error;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    refused({}, false);
    refused(creditsMessage(1), false);
    refused(helloMessage(1), true);
    refused(isovalueMessage(nan), true);
    refused(acknowledgeMessage(1), true);
    refused(viewMessage(viewFrom({nan, 0, 0}), 2), true);
    refused(viewMessage(viewFrom({0, 0, 0}), nan), true);
    refused(focusMessage({glm::dvec3(0), glm::dvec3(1)}, -1, 1), true);
    refused(focusMessage({glm::dvec3(0), glm::dvec3(1)}, 1, 0), true);
    auto older = helloMessage(1);
    older[1] = std::byte{7};
    EXPECT_NE(refused(older, false).find("version 7"), std::string::npos);
}

TEST(StreamSession, survivesAnyBytes)
{
    auto generator = tests::random(3);
    const std::vector<std::vector<std::byte>> sound{
        helloMessage(1000, {{1, 2}, {3, 4}}),
        viewMessage(viewFrom({0.4, 0.3, 0.65}), kError),
        isovalueMessage(0.1),
        focusMessage({glm::dvec3(0.4), glm::dvec3(0.5)}, 0.1, 0.01),
        creditsMessage(1000),
        acknowledgeMessage(1)};
    for (int i = 0; i < tests::trials(3000); ++i) {
        auto message = sound[tests::below(generator, sound.size())];
        message.resize(tests::below(generator, message.size() + 4));
        for (std::size_t k = 0; k < tests::below(generator, 3) && !message.empty(); ++k)
            message[tests::below(generator, message.size())] =
                static_cast<std::byte>(tests::below(generator, 256));
        static_cast<void>(protocol::parse(message));
    }
    for (int i = 0; i < tests::trials(40); ++i) {
        Talk talk;
        talk.client.looksForCracks = false;
        if (i % 4 != 0)
            talk.greet();
        for (int k = 0; k < 6; ++k) {
            auto message = sound[tests::below(generator, sound.size())];
            message[tests::below(generator, message.size())] =
                static_cast<std::byte>(tests::below(generator, 256));
            talk.say(message);
            talk.session->next();
        }
    }
}

} // namespace
} // namespace isofront::server
