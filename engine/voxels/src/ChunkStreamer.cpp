#include "isofront/voxels/ChunkStreamer.h"

#include "ChunkLoader.h"
#include "ChunkSelection.h"
#include "DeviceCache.h"
#include "ShadowCasters.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>

namespace isofront::voxels {

namespace {

using Data = std::shared_ptr<const std::vector<std::byte>>;

/// Detail is reduced in steps of this factor of a voxel's pixels: 2^(1/4).
constexpr double kCoarseningStep = 1.189207115002721;
/// Beyond, nothing but the root is left.
constexpr int kMostSteps = 400;
/// Shares of what the cache can hold: above the first detail is reduced; below the second it is
/// increased again while the view moves, or it might go back and forth. If the view rests it is
/// whatever fits, wherever it came from.
constexpr double kFull = 0.97;
constexpr double kRoomy = 0.9;
/// Once something has to leave, so much stays, so that it isn't one chunk every frame.
constexpr double kKept = 0.9;
/// While the view stays detail is increased again only so often.
constexpr int kMostReturns = 2;

class Streamer : public ChunkStreamer {
public:
    Streamer(
        const std::shared_ptr<const ChunkStore>& store,
        ChunkTree tree,
        const StreamingSettings& settings,
        std::shared_ptr<core::Jobs> jobs,
        std::vector<std::uint64_t> bytes)
        : _tree(std::move(tree)), _settings(settings), _bytes(std::move(bytes)),
          _cache(
              settings.cacheBytes,
              _bytes.empty() ? 0 : _bytes.front(),
              _bytes.empty() ? 0 : *std::ranges::max_element(_bytes)),
          _selection(_tree, settings), _isResident(_tree.size(), false),
          _hasTransition(_tree.size(), false), _lastWanted(_tree.size(), 0),
          _loader(store, _tree, _bytes, settings.form, settings.continuous, std::move(jobs))
    {
    }

    const ChunkFrame& update(
        const ChunkView& view,
        std::uint64_t frame,
        std::uint64_t completed,
        std::span<const Visibility> seen,
        const ChunkTurn& turn) override
    {
        begin(view, frame, completed, turn);
        for (const Visibility& frameSeen : seen)
            _selection.learn(frameSeen);
        takeLoaded();
        chooseDetail();
        _frame.moves = _cache.move(_settings.moveBytes, _partial);
        place();
        _frame.opaque = _selection.draws(
            frame,
            _frame.coarsening,
            [this](ChunkIndex i) { return _isResident[i]; },
            _frame.draws);
        _frame.covered = _selection.covered();
        findPlaces(_frame.draws);
        _frame.fading = static_cast<std::size_t>(std::ranges::count_if(
            _frame.draws, [](const ChunkDraw& draw) { return draw.inFormer != draw.inPresent; }));
        request();
        _frame.residentBytes = _cache.used();
        _frame.isComplete = _frame.missing == 0 && _frame.moves.empty() &&
                            !_cache.isDefragmenting() && !_selection.isChanging();
        return _frame;
    }

    std::span<const ChunkDraw> secondPass(std::span<const std::uint32_t> visible) override
    {
        _selection.secondPass(
            visible, [this](ChunkIndex i) { return _isResident[i]; }, _secondPass);
        findPlaces(_secondPass);
        return _secondPass;
    }

    std::span<const ChunkDraw> casters(const ChunkView& sun, double texel) override
    {
        _casters.clear();
        // what a damaged chunk holds instead is a part of a coarser one, which may as well cast
        // itself
        const auto isThere = [this](ChunkIndex i) {
            return _isResident[i] && !_selection.isDamaged(i);
        };
        castersInto(_tree, isThere, sun, texel, _casters);
        findPlaces(_casters);
        return _casters;
    }

    void waitForChunks() override { _loader.wait(); }
    [[nodiscard]] const ChunkTree& tree() const override { return _tree; }
    [[nodiscard]] const StreamingSettings& settings() const override { return _settings; }

private:
    void begin(
        const ChunkView& view, std::uint64_t frame, std::uint64_t completed, const ChunkTurn& turn)
    {
        _frame = {};
        _sent.clear();
        if (view.isValid()) {
            _isResting = view == _view;
            _returns = _isResting ? _returns : 0;
            _view = view;
        } else {
            _frame.isRefused = true;
        }
        ++_tick;
        _cache.begin(frame, completed);
        _selection.begin(_view, turn);
    }

    void takeLoaded()
    {
        for (ChunkLoader::Loaded& loaded : _loader.take()) {
            const ChunkIndex index = loaded.index;
            if (loaded.data)
                _ready[index] = loaded.data;
            _hasTransition[index] = loaded.hasTransition;
            if (!loaded.error) {
                _selection.markSound(index);
                continue;
            }
            if (_named.insert(index).second)
                _frame.damaged.push_back(*loaded.error);
            _selection.markDamaged(index, loaded.data ? &loaded.standIn : nullptr);
        }
    }

    [[nodiscard]] std::uint64_t totalOf(const std::vector<ChunkSelection::Wanted>& chunks) const
    {
        std::uint64_t total = 0;
        for (const ChunkSelection::Wanted& chunk : chunks)
            total += _bytes[chunk.index];
        return total;
    }

    /// Finds what the view needs, and how coarse it has to be to fit.
    void chooseDetail()
    {
        const auto wantedAt = [&](int step, std::vector<ChunkSelection::Wanted>& chunks) {
            _selection.wanted(std::pow(kCoarseningStep, step), chunks);
            return totalOf(chunks);
        };
        const auto share = [&](double of) { return of * static_cast<double>(_cache.usable()); };
        _frame.wantedBytes = wantedAt(_step, _wanted);
        const int before = _step;
        while (_step<kMostSteps&& static_cast<double>(_frame.wantedBytes)> share(kFull) &&
               _wanted.size() > 1)
            _frame.wantedBytes = wantedAt(++_step, _wanted);
        _returns += _step > before ? 1 : 0;
        while (_step > 0 && _step <= before && _returns < kMostReturns) {
            const std::uint64_t bytes = wantedAt(_step - 1, _scratch);
            if (static_cast<double>(bytes) > share(_isResting ? kFull : kRoomy))
                break;
            --_step;
            _frame.wantedBytes = bytes;
            std::swap(_wanted, _scratch);
            if (!_isResting)
                break; // more in the next frame, if there is still room
        }
        _frame.coarsening = std::pow(kCoarseningStep, _step);
        for (const ChunkSelection::Wanted& chunk : _wanted)
            _lastWanted[chunk.index] = _tick;
        keep(static_cast<std::uint64_t>(share(kFull)));
    }

    /// What is shown stays until its transition ends, as far as the cache goes beyond what the view
    /// needs.
    void keep(std::uint64_t most)
    {
        std::uint64_t bytes = _frame.wantedBytes;
        _selection.kept(_kept);
        for (const ChunkIndex index : _kept) {
            if (_lastWanted[index] == _tick)
                continue;
            bytes += _bytes[index];
            if (bytes > most)
                break;
            _lastWanted[index] = _tick;
        }
    }

    [[nodiscard]] bool hasBase(ChunkIndex index) const
    {
        const ChunkIndex parent = _tree[index].parent;
        return parent == kNoChunk || _isResident[parent] || _selection.isForced(parent);
    }

    /// Uploads what is loaded, the coarsest and nearest first, as far as this frame goes.
    void place()
    {
        if (_partial != kNoChunk && _lastWanted[_partial] != _tick)
            evict(_partial);
        if (_partial != kNoChunk)
            upload(_partial);
        for (const ChunkSelection::Wanted& chunk : _wanted) {
            if (_isResident[chunk.index] || chunk.index == _partial)
                continue;
            if (_partial != kNoChunk ||
                _frame.uploadBytes + kChunkAlignment > _settings.uploadBytes)
                break;
            if (!_ready.contains(chunk.index) || !hasBase(chunk.index))
                continue;
            if (!findRoom(chunk.index))
                break;
            _partial = chunk.index;
            _partialBytes = 0;
            upload(chunk.index);
        }
    }

    bool findRoom(ChunkIndex index)
    {
        const std::uint64_t bytes = _bytes[index];
        if (_cache.used() + bytes > _cache.usable())
            evictUntil(bytes);
        if (_cache.allocate(index, bytes))
            return true;
        // what leaves is free when the frames under way are done; if that isn't enough, what is
        // free is in pieces
        if (_cache.pending() == 0 && _cache.used() + bytes <= _cache.usable())
            _cache.makeRoom(bytes);
        return false;
    }

    void upload(ChunkIndex index)
    {
        const Data& data = _ready.at(index);
        const std::uint64_t room = _settings.uploadBytes - _frame.uploadBytes;
        const std::uint64_t bytes = std::min(room, data->size() - _partialBytes);
        _cache.use(index);
        _frame.uploadBytes += bytes;
        _frame.uploads.push_back(
            {index,
             _cache.offsetOf(index) + _partialBytes,
             std::span(*data).subspan(_partialBytes, bytes),
             _partialBytes + bytes == data->size()});
        _sent.push_back(data);
        _partialBytes += bytes;
        if (_partialBytes < data->size())
            return;
        _partial = kNoChunk;
        _isResident[index] = true;
        _ready.erase(index);
    }

    void evict(ChunkIndex index)
    {
        _cache.release(index);
        if (_partial == index)
            _partial = kNoChunk;
        if (_isResident[index])
            _frame.evictions.push_back(index);
        _isResident[index] = false;
    }

    /// Lets go what this view doesn't need, what wasn't needed for longest first, finest first.
    void evictUntil(std::uint64_t bytes)
    {
        std::vector<ChunkIndex> idle;
        for (ChunkIndex i = 0; i < _tree.size(); ++i)
            if (_isResident[i] && _lastWanted[i] != _tick)
                idle.push_back(i);
        // parents are needed whenever a child is and come first in the tree, so children go first
        std::ranges::sort(idle, [&](ChunkIndex a, ChunkIndex b) {
            return std::tie(_lastWanted[a], b) < std::tie(_lastWanted[b], a);
        });
        const auto kept = static_cast<std::uint64_t>(kKept * static_cast<double>(_cache.usable()));
        for (const ChunkIndex index : idle) {
            if (_cache.used() + bytes <= kept)
                break;
            evict(index);
        }
    }

    void findPlaces(std::vector<ChunkDraw>& draws)
    {
        for (ChunkDraw& draw : draws) {
            draw.offset = _cache.offsetOf(draw.index);
            _cache.use(draw.index);
            const ChunkIndex parent = _tree[draw.index].parent;
            draw.fades = draw.weight < 1 && !draw.occlusionOnly && _hasTransition[draw.index] &&
                         parent != kNoChunk && _isResident[parent] && !_selection.isDamaged(parent);
            if (!draw.fades)
                continue;
            draw.transitionOffset =
                draw.offset + transitionOffset(_settings.form, _tree[draw.index].entry);
            draw.parentOffset = _cache.offsetOf(parent);
            _cache.use(parent); // read for this frame, too
        }
    }

    /// Asks for what is missing, the first of it that may wait on the host together, and lets go
    /// what is loaded beyond that.
    void request()
    {
        std::vector<ChunkIndex> chunks;
        std::vector<ChunkIndex> kept;
        std::uint64_t waiting = 0; ///< of what is to be loaded by and by
        std::uint64_t loaded = 0;  ///< of what is
        const auto keep = [&](ChunkIndex index) {
            kept.push_back(index);
            loaded += _bytes[index];
        };
        if (_partial != kNoChunk) {
            keep(_partial);
            waiting = loaded;
        }
        for (const ChunkSelection::Wanted& chunk : _wanted) {
            if (_isResident[chunk.index])
                continue;
            ++_frame.missing;
            if (chunk.index == _partial)
                continue;
            const bool isFirst = waiting == 0;
            waiting += _bytes[chunk.index];
            if (waiting > _settings.hostBytes && !isFirst)
                continue;
            if (_ready.contains(chunk.index))
                keep(chunk.index);
            else
                chunks.push_back(chunk.index);
        }
        std::ranges::sort(kept);
        std::erase_if(_ready, [&](const auto& ready) {
            return !std::ranges::binary_search(kept, ready.first);
        });
        _loader.want(
            chunks, _settings.hostBytes > loaded ? _settings.hostBytes - loaded : 0, kept.empty());
    }

    ChunkTree _tree;
    StreamingSettings _settings;
    std::vector<std::uint64_t> _bytes; ///< of each chunk in the cache
    DeviceCache _cache;
    ChunkSelection _selection;
    ChunkView _view;
    ChunkFrame _frame;
    std::uint64_t _tick = 0;
    std::vector<bool> _isResident;          ///< drawable; parents before their children
    std::vector<bool> _hasTransition;       ///< of those that are loaded
    std::vector<std::uint64_t> _lastWanted; ///< tick
    std::vector<ChunkSelection::Wanted> _wanted;
    std::vector<ChunkSelection::Wanted> _scratch;
    std::vector<ChunkIndex> _kept;
    std::vector<ChunkDraw> _secondPass;
    std::vector<ChunkDraw> _casters;
    int _step = 0;    ///< of coarsening
    int _returns = 0; ///< how often it rose in this view
    bool _isResting = false;
    std::map<ChunkIndex, Data> _ready;
    std::set<ChunkIndex> _named;     ///< that can't be read, and were reported
    std::vector<Data> _sent;         ///< this frame's
    ChunkIndex _partial = kNoChunk;  ///< has a place, but not all of its bytes
    std::uint64_t _partialBytes = 0; ///< that it has
    ChunkLoader _loader;             ///< last, so that its jobs end before all else
};

} // namespace

core::Result<std::unique_ptr<ChunkStreamer>> ChunkStreamer::create(
    std::shared_ptr<const ChunkStore> store,
    const StreamingSettings& settings,
    std::shared_ptr<core::Jobs> jobs)
{
    if (!(settings.voxelPixels > 0) || !(settings.sourcePixels > 0) ||
        settings.uploadBytes < kChunkAlignment)
        return core::failure(
            core::ErrorCode::usage,
            "streaming needs bounds on pixels above 0, and at least " +
                std::to_string(kChunkAlignment) + " bytes to upload a frame");
    const auto directory = store->directory();
    if (!directory)
        return tl::unexpected(directory.error());
    auto tree = ChunkTree::create(store->model().lattice, *directory);
    if (!tree)
        return tl::unexpected(tree.error().within(store->model().name));
    std::vector<std::uint64_t> bytes(tree->size());
    for (ChunkIndex i = 0; i < tree->size(); ++i) {
        const ChunkEntry& entry = (*tree)[i].entry;
        const bool fades = settings.continuous && (*tree)[i].parent != kNoChunk;
        bytes[i] = alignedBytes(
            fades ? transitionOffset(settings.form, entry) + transitionBytes(entry)
                  : settings.form.bytes(entry));
    }
    if (!bytes.empty() && bytes.front() > settings.cacheBytes)
        return core::failure(
            core::ErrorCode::resourceLimit,
            "the coarsest chunk takes " + std::to_string(bytes.front()) +
                " bytes, more than the cache has (" + std::to_string(settings.cacheBytes) +
                "); give it more");
    return std::make_unique<Streamer>(
        store, std::move(*tree), settings, std::move(jobs), std::move(bytes));
}

} // namespace isofront::voxels
