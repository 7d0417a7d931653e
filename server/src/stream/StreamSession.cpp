#include "StreamSession.h"

#include "Bytes.h"

#include <algorithm>
#include <exception>
#include <string>
#include <utility>

namespace isofront::server {
namespace {

/// Of the thread that all streams share [ms].
constexpr double kTurnMilliseconds = 2;
/// Cells that are encoded between two chances for others to have the lock.
constexpr std::size_t kEncodedAtOnce = 32;
/// What may be sent in vain before what is more than half there is finished first [bytes].
constexpr std::uint64_t kPatience = std::uint64_t{256} << 10U;
/// About what a triangle takes [bytes].
constexpr std::uint64_t kBytesPerTriangle = 5;
/// About what it takes to know that a cell is wanted or shown [bytes].
constexpr std::size_t kBytesPerCell = 80;
/// Transactions that a client may be behind.
constexpr std::uint64_t kMostUnacknowledged = 4;
constexpr std::uint64_t kMostCredits = std::uint64_t{1} << 40U;
/// Of what a client keeps beyond what it shows [bytes]: knowing it takes memory here, too.
constexpr std::uint64_t kMostCache = std::uint64_t{256} << 20U;

bool isSame(const hierarchy::View& a, const hierarchy::View& b)
{
    return a.eye == b.eye && a.forward == b.forward && a.up == b.up &&
           a.verticalFieldOfView == b.verticalFieldOfView && a.width == b.width &&
           a.height == b.height;
}

} // namespace

StreamSession::StreamSession(Setup setup) : _setup(std::move(setup))
{
    const sources::Source& source = _setup.scene->source;
    _surface = std::make_unique<surface::Surface>(
        source.field, source.domain, _setup.surface, _setup.jobs);
    _isovalue = source.fieldIsovalue(_setup.surface.extraction.isovalue);
    _wantedIsovalue = _isovalue;
    _effectiveError = _setup.surface.pixelError;
    if (_setup.scheduler != nullptr)
        _setup.scheduler->add(*this);
}

StreamSession::~StreamSession()
{
    if (_setup.end)
        _setup.end(*this);
    if (_setup.scheduler != nullptr) {
        _setup.scheduler->remove(*this);
        // taking it apart waits for its cells under way, which nobody else should
        _setup.scheduler->doLater([scene = _setup.scene,
                                   surface = std::shared_ptr<surface::Surface>(
                                       std::move(_surface))]() mutable { surface.reset(); });
    }
}

void StreamSession::whenReady(std::function<void()> wake)
{
    const std::lock_guard lock(_wakeMutex);
    _wake = std::move(wake);
}

void StreamSession::wakeTransport()
{
    const std::lock_guard lock(_wakeMutex);
    if (_wake)
        _wake();
}

bool StreamSession::isOver() const
{
    const std::lock_guard lock(_mutex);
    return _isOver;
}

// What the client says

void StreamSession::receive(std::span<const std::byte> message)
{
    const std::lock_guard lock(_mutex);
    if (_refusal)
        return;
    if (const auto parsed = protocol::parse(message))
        take(*parsed);
    else
        refuse(parsed.error());
}

void StreamSession::take(const protocol::ClientMessage& message)
{
    if (_isGreeted == std::holds_alternative<protocol::Hello>(message))
        refuse(
            {core::ErrorCode::badData,
             "a hello must come first, and once (see docs/protocol.md, version 1)"});
    else
        std::visit([this](const auto& content) { take(content); }, message);
}

void StreamSession::take(const protocol::Hello& hello)
{
    _isGreeted = true;
    _held.setCapacity(std::min(hello.cacheBytes, kMostCache));
    for (const protocol::Hello::Held& payload : hello.held)
        _held.insert(payload.hash, payload.bytes);
    _isReturning = !hello.held.empty();
}

void StreamSession::take(const protocol::ViewChange& change)
{
    if (_view && isSame(*_view, change.view) && _pixelError == change.pixelError)
        return;
    if (_view)
        _isReturning = false; // it moves: there is no telling when all would be there
    _isDetailNew = _isDetailNew || _pixelError != change.pixelError;
    _view = change.view;
    _pixelError = change.pixelError;
    this->change();
}

void StreamSession::take(const protocol::IsovalueChange& change)
{
    if (_isovalue == change.isovalue)
        return;
    _isovalue = change.isovalue;
    _isIsovalueNew = true;
    this->change();
}

void StreamSession::take(const protocol::FocusChange& change)
{
    _detail.focus = change.focus;
    _isDetailNew = true;
    this->change();
}

void StreamSession::take(const protocol::Credits& credits)
{
    _credits += std::min(credits.bytes, kMostCredits - _credits);
}

void StreamSession::take(const protocol::Acknowledgement& acknowledgement)
{
    if (acknowledgement.transaction > _transactions || acknowledgement.transaction <= _acknowledged)
        refuse(
            {core::ErrorCode::badData,
             "transaction " + std::to_string(acknowledgement.transaction) +
                 " isn't there to be acknowledged (see docs/protocol.md, version 1)"});
    else
        _acknowledged = acknowledgement.transaction;
}

void StreamSession::change()
{
    _isChanging = true;
    _isSettled = false;
    _isSettledTold = false;
    _changed = Clock::now();
    _isChangeTold = false;
    if (_setup.scheduler != nullptr)
        _setup.scheduler->wake(*this);
}

void StreamSession::refuse(core::Error error)
{
    _refusal = std::move(error);
}

// What the surface says

StreamScheduler::Outcome StreamSession::advance()
{
    try {
        return advanceSurface();
    } catch (const std::exception& failed) {
        // memory, most likely: this client's stream ends, and not those of all
        {
            const std::lock_guard lock(_mutex);
            refuse(
                {core::ErrorCode::resourceLimit,
                 std::string("the stream failed: ") + failed.what()});
        }
        wakeTransport();
        return StreamScheduler::Outcome::idle;
    }
}

StreamScheduler::Outcome StreamSession::advanceSurface()
{
    using Outcome = StreamScheduler::Outcome;
    std::unique_lock lock(_mutex);
    if (_refusal || !_view || !mayAdvance())
        return Outcome::idle;
    if (std::exchange(_isDetailNew, false))
        _surface->setDetail(_pixelError, _detail);
    if (std::exchange(_isIsovalueNew, false))
        _surface->setIsovalue(_setup.scene->source.fieldIsovalue(_isovalue));
    const surface::Delta delta =
        _surface->update(*_view, {.milliseconds = kTurnMilliseconds, .hostBytes = _held.bytes()});
    want(delta);
    _isSettled = _surface->isSettled();
    if (_isSettled || !delta.isEmpty())
        _isChanging = false;
    if (_isSettled) {
        _isReturning = false;
        // from nothing to nothing there is no change of cells that would tell
        _wantedIsovalue = _isovalue;
    }
    const surface::SurfaceStats stats = _surface->stats();
    _effectiveError = stats.effectivePixelError;
    _bytes.store(
        stats.hierarchyBytes + _held.bytes() + (_wanted.size() + _shown.size()) * kBytesPerCell,
        std::memory_order_relaxed);
    const Outcome outcome = _isSettled        ? Outcome::idle
                            : delta.isEmpty() ? Outcome::waiting
                                              : Outcome::busy;
    lock.unlock();
    if (outcome != Outcome::waiting) {
        wakeTransport();
        if (_setup.report)
            _setup.report();
    }
    return outcome;
}

void StreamSession::want(const surface::Delta& delta)
{
    if (delta.isEmpty())
        return;
    _wantedIsovalue = _setup.scene->source.fieldIsovalue(delta.isovalue);
    std::size_t superseded = 0;
    for (const CellId& id : delta.removed) {
        const auto found = _wanted.find(id);
        if (const auto& mesh = found->second.mesh) {
            ++superseded;
            --_lacking;
            _lackingTriangles -= mesh->triangleCount();
            if (_encoded && _encoded->id == id)
                _encoded.reset();
        }
        _wanted.erase(found);
        _different.insert(id);
    }
    if (superseded > 0)
        _setup.metrics->count(Metrics::Count::superseded, static_cast<double>(superseded));
    for (const surface::ShownCell& cell : delta.added) {
        _wanted[cell.id].mesh = cell.mesh();
        ++_lacking;
        _lackingTriangles += cell.mesh()->triangleCount();
        _toSend.push_back(cell.id);
        _different.insert(cell.id);
    }
    // what is superseded stays in line; before that piles up, all of it goes
    if (_toSend.size() > 1024 && _toSend.size() > 4 * _lacking)
        std::erase_if(_toSend, [this](const CellId& id) {
            const auto found = _wanted.find(id);
            return found == _wanted.end() || !found->second.mesh;
        });
}

bool StreamSession::hasCaughtUp() const
{
    return _lacking == 0 && _different.empty() && !_transaction;
}

bool StreamSession::mayAdvance() const
{
    if (_isSettled && !_isChanging)
        return false;
    if (_isReturning || hasCaughtUp())
        return true;
    // The client has changed its mind: what it lacks may be superseded. But who does so all the
    // time must come to see something, too.
    const bool isMoreThanHalfThere =
        _bytesSince >= kPatience && _bytesSince >= kBytesPerTriangle * _lackingTriangles;
    return _isChanging && !_transaction && !isMoreThanHalfThere;
}

// What is sent

std::optional<std::vector<std::byte>> StreamSession::next()
{
    while (true) {
        const std::lock_guard lock(_mutex);
        Step step = this->step();
        if (step.goesOn)
            continue;
        if (!step.message && _setup.scheduler != nullptr && _view && mayAdvance())
            _setup.scheduler->wake(*this);
        return std::move(step.message);
    }
}

StreamSession::Step StreamSession::step()
{
    if (_refusal) {
        if (std::exchange(_isOver, true))
            return {};
        return {protocol::encodeError(*_refusal)};
    }
    if (!_isGreeted)
        return {};
    if (!std::exchange(_isWelcomed, true))
        return {welcome()};
    if (_isReturning)
        return {};
    if (_transaction)
        return sendPart();
    if (_lacking > 0)
        return sendCells();
    if (mayBegin())
        begin();
    return _transaction ? sendPart() : Step{};
}

std::vector<std::byte> StreamSession::welcome() const
{
    const sources::Source& source = _setup.scene->source;
    protocol::Welcome welcome;
    welcome.domain = source.domain;
    welcome.isovalue = source.fieldIsovalue(_setup.surface.extraction.isovalue);
    welcome.bounds = source.worldBox;
    welcome.eye = source.eye;
    welcome.target = source.target;
    welcome.up = source.up;
    return protocol::encode(welcome);
}

/// Encodes what is to be sent next, unless the client has it.
/// @return false if it did, or if what came up was superseded
bool StreamSession::encodeNext()
{
    const CellId id = _toSend.front();
    _toSend.pop_front();
    const auto found = _wanted.find(id);
    if (found == _wanted.end() || !found->second.mesh)
        return false;
    std::shared_ptr<const CellPayload> payload = _setup.payloads->encoded(found->second.mesh);
    if (_held.contains(payload->hash)) {
        resolve(found->second, payload->hash);
        return false;
    }
    _encoded = {id, std::move(payload)};
    return true;
}

void StreamSession::resolve(Wanted& cell, std::uint64_t hash)
{
    --_lacking;
    _lackingTriangles -= cell.mesh->triangleCount();
    cell.hash = hash;
    cell.mesh.reset(); // the surface has it, as long as it shows it
}

StreamSession::Step StreamSession::sendCells()
{
    ByteWriter message;
    message.put(static_cast<std::uint8_t>(protocol::ServerType::cells)).put(std::uint8_t{0});
    message.put(std::uint16_t{0}).put(std::uint32_t{0});
    std::uint32_t count = 0;
    bool isFull = false;
    for (std::size_t looked = 0; looked < kEncodedAtOnce && _lacking > 0 && !isFull; ++looked) {
        if (!_encoded && !encodeNext())
            continue;
        const CellPayload& payload = *_encoded->payload;
        const std::size_t size = message.size() + protocol::kCellHeaderBytes + payload.bytes.size();
        isFull = size > _credits || (count > 0 && size > protocol::kLongestMessage);
        if (isFull)
            continue;
        message.put(payload.hash).put(static_cast<std::uint32_t>(payload.bytes.size()));
        message.put(payload.bytes);
        _held.insert(payload.hash, payload.bytes.size());
        resolve(_wanted.at(_encoded->id), payload.hash);
        _encoded.reset();
        ++count;
    }
    if (count == 0)
        return {{}, !isFull};
    message.replace(4, count);
    _credits -= message.size();
    _bytesSince += message.size();
    _setup.metrics->count(Metrics::Count::cellsSent, count);
    return {message.take()};
}

bool StreamSession::mayBegin() const
{
    return _transactions - _acknowledged < kMostUnacknowledged &&
           (!_different.empty() || (_isSettled && !_isSettledTold));
}

/// Decides on a transaction: from what the client shows to what the surface shows, all of which the
/// client has.
void StreamSession::begin()
{
    Transaction transaction;
    transaction.id = _transactions + 1;
    transaction.isSettled = _isSettled;
    transaction.isovalue = _wantedIsovalue;
    transaction.pixelError = _effectiveError;
    for (const CellId& id : _different) {
        const auto is = _wanted.find(id);
        const auto was = _shown.find(id);
        if (is != _wanted.end() && was != _shown.end() && is->second.hash == was->second)
            continue;
        if (is != _wanted.end()) {
            transaction.added.push_back({id, is->second.hash});
            _held.show(is->second.hash);
        }
        if (was != _shown.end()) {
            transaction.removed.push_back(id);
            _held.hide(was->second);
            _shown.erase(was);
        }
    }
    _different.clear();
    _bytesSince = 0;
    for (const protocol::AddedCell& cell : transaction.added)
        _shown[cell.id] = cell.hash;
    transaction.forgotten = _held.endTurn();
    if (transaction.removed.empty() && transaction.added.empty() && transaction.forgotten.empty() &&
        !transaction.isSettled)
        return;
    _isSettledTold = transaction.isSettled;
    _transaction = std::move(transaction);
}

/// Sends as much of the transaction as fits a message and the client's credits.
StreamSession::Step StreamSession::sendPart()
{
    Transaction& transaction = *_transaction;
    std::size_t room = std::min<std::uint64_t>(protocol::kLongestMessage, _credits);
    if (room < protocol::kTransactionHeaderBytes)
        return {};
    room -= protocol::kTransactionHeaderBytes;
    bool isLast = true;
    const auto portion = [&](const auto& all, std::size_t& sent, std::size_t size) {
        const std::size_t count = std::min(all.size() - sent, room / size);
        const auto part = std::span(all).subspan(sent, count);
        sent += count;
        room -= count * size;
        isLast = isLast && sent == all.size();
        if (!isLast)
            room = 0;
        return part;
    };
    protocol::TransactionPart part;
    part.id = transaction.id;
    part.isovalue = transaction.isovalue;
    part.pixelError = transaction.pixelError;
    part.milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - _changed).count();
    part.removed = portion(transaction.removed, transaction.removedSent, protocol::kRemovedBytes);
    part.added = portion(transaction.added, transaction.addedSent, protocol::kAddedBytes);
    part.forgotten =
        portion(transaction.forgotten, transaction.forgottenSent, protocol::kForgottenBytes);
    part.isLast = isLast;
    part.isSettled = transaction.isSettled;
    if (!isLast && part.removed.empty() && part.added.empty() && part.forgotten.empty())
        return {};
    Step step{protocol::encode(part)};
    _credits -= step.message->size();
    if (isLast) {
        _transactions = transaction.id;
        _setup.metrics->count(Metrics::Count::transactions);
        if (transaction.isSettled && !std::exchange(_isChangeTold, true))
            _setup.metrics->settled(part.milliseconds / 1000);
        _transaction.reset();
        if (_setup.scheduler != nullptr && mayAdvance())
            _setup.scheduler->wake(*this);
    }
    return step;
}

} // namespace isofront::server
