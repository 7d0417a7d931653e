#pragma once

namespace isofront::render {

/// The clock of everything that changes where one can see it. It cuts time into transitions of
/// equal length: when one begins, what has been asked for since the last began becomes the present
/// picture, and what was present becomes the former one; while it runs, the weight of the present
/// picture rises from 0 to 1. So nothing starts to fade before what fades has ended.
///
/// Call `begins` once a frame. Where it is true, call `Renderer::beginTransition` after the frame's
/// deltas; give `weight` to `Scene::transition`.
///
/// Thread: one at a time.
class TransitionClock {
public:
    /// @param seconds  length of a transition; 0, or anything that isn't a positive number: nothing
    ///                 fades, every frame begins one and shows its end
    explicit TransitionClock(double seconds);

    /// @param now  the frame's time [s], from anywhere. If it goes back, or ahead by more than a
    ///             transition, what is asked for is shown at once.
    /// @return whether a transition begins with this frame
    bool begins(double now);
    /// Of the present picture in the last frame, in [0, 1]. It grows with time evenly: then the
    /// same share of the pixels changes in each frame.
    [[nodiscard]] float weight() const { return _weight; }
    [[nodiscard]] double length() const { return _length; } ///< [s]

private:
    double _length;
    double _start = 0;
    bool _isStarted = false;
    float _weight = 1;
};

} // namespace isofront::render
