#pragma once

#include "../Metrics.h"
#include "../scenes/SceneRegistry.h"
#include "CellCodec.h"
#include "HeldPayloads.h"
#include "Protocol.h"
#include "SharedPayloads.h"
#include "Stream.h"
#include "StreamScheduler.h"

#include <isofront/core/Jobs.h>
#include <isofront/surface/Surface.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <unordered_map>
#include <vector>

namespace isofront::server {

/// What one client sees of a scene: docs/protocol.md.
///
/// A Surface of its own follows the client's view, and says what is wanted. What the client shows
/// trails it: payloads of the cells that differ are sent as credits allow, and when all are there,
/// one transaction leads to a whole shown front, so that the client's mesh has no cracks. There is
/// no queue: what is wanted no longer when its turn comes is never sent. The Surface takes its next
/// step when the client has caught up with the last, or has changed its mind.
///
/// Thread: those of Stream; `advance` from any.
class StreamSession final : public Stream, public StreamScheduler::Task {
public:
    struct Setup {
        std::shared_ptr<const OpenScene> scene;
        surface::SurfaceOptions surface;
        std::shared_ptr<core::Jobs> jobs;
        std::shared_ptr<SharedPayloads> payloads;
        StreamScheduler* scheduler = nullptr; ///< null if somebody else calls `advance`
        Metrics* metrics = nullptr;
        std::function<void()> report = {}; ///< called now and then while there is work
        std::function<void(const StreamSession&)> end = {}; ///< called before it goes
    };
    explicit StreamSession(Setup setup);
    ~StreamSession() override;

    void receive(std::span<const std::byte> message) override;
    std::optional<std::vector<std::byte>> next() override;
    void whenReady(std::function<void()> wake) override;
    [[nodiscard]] bool isOver() const override;

    StreamScheduler::Outcome advance() override;
    /// What following the client takes [bytes], about, but for the meshes that it sees: those may
    /// be others' too. Thread: any.
    [[nodiscard]] std::size_t bytes() const { return _bytes.load(std::memory_order_relaxed); }

private:
    using Clock = std::chrono::steady_clock;
    using CellId = hierarchy::CellId;

    /// A cell that the surface shows.
    struct Wanted {
        std::shared_ptr<const extractor::CellMesh> mesh; ///< until its payload is with the client
        std::uint64_t hash = 0;                          ///< from then on
    };
    /// Decided, and on its way in parts.
    struct Transaction {
        std::uint64_t id = 0;
        bool isSettled = false;
        double isovalue = 0;
        double pixelError = 0;
        std::vector<CellId> removed;
        std::vector<protocol::AddedCell> added;
        std::vector<std::uint64_t> forgotten;
        std::size_t removedSent = 0;
        std::size_t addedSent = 0;
        std::size_t forgottenSent = 0;
    };
    /// What a step towards the next message has led to.
    struct Step {
        std::optional<std::vector<std::byte>> message;
        bool goesOn = false; ///< there may be one, with more work
    };

    // messages of the client; with the lock
    void take(const protocol::ClientMessage& message);
    void take(const protocol::Hello& hello);
    void take(const protocol::ViewChange& change);
    void take(const protocol::IsovalueChange& change);
    void take(const protocol::FocusChange& change);
    void take(const protocol::Credits& credits);
    void take(const protocol::Acknowledgement& acknowledgement);
    void change();
    void refuse(core::Error error);

    // what is sent; with the lock
    Step step();
    Step sendCells();
    bool encodeNext();
    void resolve(Wanted& cell, std::uint64_t hash);
    void begin();
    Step sendPart();
    [[nodiscard]] bool mayBegin() const;
    [[nodiscard]] bool hasCaughtUp() const;
    [[nodiscard]] bool mayAdvance() const;
    StreamScheduler::Outcome advanceSurface();
    void want(const surface::Delta& delta);
    std::vector<std::byte> welcome() const;
    void wakeTransport();

    const Setup _setup;
    mutable std::mutex _mutex;
    std::unique_ptr<surface::Surface> _surface;

    // the client's wishes
    bool _isGreeted = false;
    /// It has brought payloads, and is shown nothing before what they are of is there again: the
    /// way to that would be through cells that it doesn't have.
    bool _isReturning = false;
    std::optional<hierarchy::View> _view;
    double _pixelError = 0;
    surface::DetailSettings _detail;
    double _isovalue = 0; ///< [the source's units]
    bool _isDetailNew = false;
    bool _isIsovalueNew = false;
    std::uint64_t _credits = 0;

    // what the surface shows
    std::unordered_map<CellId, Wanted, hierarchy::CellIdHash> _wanted;
    double _wantedIsovalue = 0; ///< [the source's units]
    double _effectiveError = 0;
    bool _isChanging = false; ///< the surface hasn't yet answered the latest wish
    bool _isSettled = false;
    bool _isSettledTold = true;
    Clock::time_point _changed;
    bool _isChangeTold = true; ///< how long it took to settle

    // on the way
    std::set<CellId> _different; ///< may be other than what the client shows
    std::deque<CellId> _toSend;  ///< whose payloads the client may lack, and that once were wanted
    std::size_t _lacking = 0;    ///< wanted cells with a mesh
    std::uint64_t _lackingTriangles = 0;
    struct Encoded {
        CellId id;
        std::shared_ptr<const CellPayload> payload;
    };
    std::optional<Encoded> _encoded; ///< wanted, lacking, and not yet sent
    std::optional<Transaction> _transaction;
    std::uint64_t _bytesSince = 0; ///< sent since the last transaction

    // what the client has
    std::unordered_map<CellId, std::uint64_t, hierarchy::CellIdHash> _shown;
    HeldPayloads _held;
    std::uint64_t _transactions = 0;
    std::uint64_t _acknowledged = 0;

    std::atomic<std::size_t> _bytes = 0;
    bool _isWelcomed = false;
    std::optional<core::Error> _refusal;
    bool _isOver = false;

    std::mutex _wakeMutex; ///< of what follows; never taken before the other
    std::function<void()> _wake;
};

} // namespace isofront::server
