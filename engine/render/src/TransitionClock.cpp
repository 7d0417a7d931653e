#include "isofront/render/TransitionClock.h"

#include <cmath>

namespace isofront::render {

TransitionClock::TransitionClock(double seconds)
    : _length(std::isfinite(seconds) && seconds > 0 ? seconds : 0)
{
}

bool TransitionClock::begins(double now)
{
    const double elapsed = now - _start;
    if (_isStarted && elapsed >= 0 && elapsed < _length) {
        _weight = static_cast<float>(elapsed / _length);
        return false;
    }
    const double beyond = elapsed - _length;
    if (_isStarted && beyond >= 0 && beyond < _length) {
        _start += _length;
        _weight = static_cast<float>(beyond / _length);
        return true;
    }
    // A whole transition has passed unseen. The next frame begins another.
    _start = now - _length;
    _isStarted = true;
    _weight = 1;
    return true;
}

} // namespace isofront::render
