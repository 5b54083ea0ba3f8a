"""What each reduction of the problem buys; :mod:`studies.reductions.reductions` is the study."""
