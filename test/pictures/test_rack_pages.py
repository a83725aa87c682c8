"""The pages of a rack: each shot has one, with links to the others and to the list."""

import re

import pytest

from billiard_shot import Scene
from billiard_shot.game.rack import Pairing, play
from billiard_shot.pictures import rack
from billiard_shot.pictures.rack import write_rack

TABLE = Scene.load('seven_foot')


@pytest.fixture(scope='module')
def record():
    played = play(Pairing('practice', TABLE, ('greedy',), seed=4, balls=3), 0)
    assert len(played.shots) > 2
    return played


def links_in(page):
    return dict(
        reversed(each) for each in re.findall(r'<a href="([^"]*)">([^<]*)</a>', page.read_text())
    )


def test_each_page_leads_to_the_next(record, tmp_path):
    pytest.importorskip('matplotlib', reason='needs matplotlib, an extra')
    listed = write_rack(record, TABLE, tmp_path / 'rack')
    names = re.findall(r'<a href="(shot-\d+.html)"><img src="(shot-\d+.png)"', listed.read_text())
    pages = [listed.parent / page for page, _ in names]
    assert len(pages) == len(record.shots)
    for _, picture in names:
        assert (listed.parent / picture).read_bytes().startswith(b'\x89PNG')
    for before, page, after in zip([None, *pages], pages, [*pages[1:], None], strict=False):
        links = {'All shots': listed.name}
        links |= {'← Previous': before.name} if before else {}
        links |= {'Next →': after.name} if after else {}
        assert links_in(page) == links


def test_without_matplotlib_the_list_has_no_pictures(record, tmp_path, monkeypatch):
    monkeypatch.setattr(rack, 'has_matplotlib', lambda: False)
    listed = write_rack(record, TABLE, tmp_path)
    assert listed.read_text().count('<li>') == len(record.shots)
    assert not list(tmp_path.glob('*.png'))
    assert '<img' not in listed.read_text()
