"""What each reduction of the problem saves; :mod:`studies.reductions.reductions` is the study."""
